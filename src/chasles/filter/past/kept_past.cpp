#include <algorithm>
#include <string>
#include <utility>

#include <chasles/base/error.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/filter/past/kept_past.hpp>
#include <chasles/filter/present_landmark.hpp>

// States that leave the filter, and return (docs/map.md).

namespace chasles {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

KeptPast::KeptPast(const MatrixXd& core_covariance, Options options)
    : map_(options.map),
      core_(core_covariance.rows()),
      left_(options.past),
      history_(core_covariance, options.map_bytes) {
  latest_.clear(core_);
}

void KeptPast::reject_with_history(const char* what) const {
  if (keeps_steps()) throw UsageError(std::string(what) + " a filter without Map::kHistory");
}

// Ending a segment costs little. A segment's steps cost the more the more states have left in it.
void KeptPast::end_segment_when_due(const Covariance& covariance) {
  constexpr Index kMostRows = 120;
  if (latest_.item_rows() < kMostRows) return;
  left_.append(latest_.segment(), covariance.all());
  latest_.begin(covariance.size());
}

void KeptPast::leave(const Landmark& landmark, const State& x, const Covariance& covariance) {
  if (keeps_steps() || !landmark.has_place()) return;
  if (map_ == Map::kFrozen) {
    frozen_.push_back(as_of_now(x, covariance, landmark));
    return;
  }
  const auto P = covariance.all();
  latest_.add_item({.number = left_.add(landmark), .size = 3}, P.middleRows<3>(landmark.row),
                   P.block<3, 3>(landmark.row, landmark.row),
                   latest_.Z().middleCols<3>(landmark.row));
}

void KeptPast::end_leaving(std::span<const int> indices, const State& x) {
  if (!keeps_steps()) return;
  History::Removal removal{.indices = {indices.begin(), indices.end()}, .landmarks = {}};
  removal.landmarks.reserve(indices.size());
  for (const int index : indices) {
    removal.landmarks.push_back(x.landmarks[static_cast<std::size_t>(index)]);
  }
  history_.append(std::move(removal));
}

void KeptPast::remember_pose(Time time, const State& x, const Covariance& covariance) {
  if (keeps_steps()) {
    history_.append(History::Pose{.time = time, .world_T_imu = x.world_T_imu});
    return;
  }
  remember_pose(time, x.world_T_imu, MatrixXd::Identity(6, x.core_size()), covariance);
}

void KeptPast::remember_pose(Time time, const SE3& map_T_imu, const MatrixXd& d_core,
                             const Covariance& covariance) {
  if (!is_in_map_axes()) throw UsageError("past poses need a filter with Map::kPast");
  const Index n = d_core.cols();
  const MatrixXd with_state = d_core * covariance.all().topRows(n);
  latest_.add_item({.number = left_.add(time, map_T_imu), .size = 6}, with_state,
                   with_state.leftCols(n) * d_core.transpose(),
                   latest_.Z().leftCols(n) * d_core.transpose());
}

void KeptPast::check_can_return(std::span<const int> numbers) const {
  if (!is_in_map_axes()) {
    throw UsageError("landmarks return in a filter with Map::kPast alone");
  }
  if (std::ranges::all_of(numbers, [&](int number) { return left_.can_return(number); })) return;
  throw UsageError(
      "a landmark cannot return: expected past.recalls, and numbers of past landmarks that have "
      "not returned");
}

Carried KeptPast::revive(const std::vector<int>& numbers, const Covariance& covariance) {
  Carried past;
  if (map_ == Map::kDense) {
    carry(past, latest_.segment(), numbers);
    left_.note_returned(numbers);
    latest_.make_states(numbers);
  } else {
    left_.append(latest_.segment(), covariance.all());
    past = left_.revive(numbers);
    latest_.begin(covariance.size() + past.rows());
  }
  return past;
}

void KeptPast::note_returned(std::span<const int> numbers) {
  left_.note_returned({numbers.begin(), numbers.end()});
}

void KeptPast::check_fits(const PriorMap& prior) const {
  if (!is_in_map_axes() || !left_.recalls()) {
    throw UsageError("a prior map needs a filter with Map::kPast and past.recalls");
  }
  const auto landmarks = static_cast<Index>(prior.landmarks.size());
  if (prior.shared.rows() != 6 + 3 * landmarks || prior.own.size() != prior.landmarks.size()) {
    throw UsageError("a prior map has six rows of shared errors, and three for each landmark");
  }
}

int KeptPast::consider(PriorMap prior) {
  check_fits(prior);
  latest_.append_rows(static_cast<int>(prior.shared.cols()));
  return left_.add(std::move(prior));
}

int KeptPast::add_past(PriorMap prior, const Covariance& covariance) {
  check_fits(prior);
  const Index n = covariance.size();
  if (map_ == Map::kDense) {
    add_dense(prior, n);
    return left_.add(std::move(prior), true);
  }
  const Index r = prior.shared.cols();
  left_.append(latest_.segment(), covariance.all());
  const int frame = left_.add(std::move(prior));
  Segment segment{.starts = n,
                  .items = {{.number = frame, .size = static_cast<int>(r)}},
                  .X = MatrixXd::Identity(n, n + r),
                  .G = MatrixXd::Zero(n + r, n + r),
                  .g = VectorXd::Zero(n + r)};
  segment.G.bottomRightCorner(r, r).setIdentity();
  left_.append(std::move(segment), covariance.all());
  latest_.begin(n);
  return frame;
}

// All landmarks as items.
void KeptPast::add_dense(const PriorMap& prior, Index n) {
  const Index r = prior.shared.cols();
  const int frame = left_.states();
  MatrixXd all(r + prior.shared.rows() - 6, r);
  all << MatrixXd::Identity(r, r), prior.shared.bottomRows(prior.shared.rows() - 6);
  const Index first = latest_.variables();
  const auto add = [&](int number, int size, Index row, const MatrixXd& own) {
    const MatrixXd A = all.middleRows(row, size);
    MatrixXd with_variables = MatrixXd::Zero(latest_.variables(), size);
    with_variables.bottomRows(latest_.variables() - first) = all.topRows(row) * A.transpose();
    latest_.add_item({.number = number, .size = size}, MatrixXd::Zero(size, n),
                     A * A.transpose() + own, with_variables);
  };
  add(frame, static_cast<int>(r), 0, MatrixXd::Zero(r, r));
  for (std::size_t i = 0; i < prior.landmarks.size(); ++i) {
    const auto index = static_cast<int>(i);
    add(frame + 1 + index, 3, r + 3 * index, prior.own[i]);
  }
}

}  // namespace chasles
