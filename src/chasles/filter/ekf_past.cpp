#include <algorithm>
#include <optional>
#include <utility>

#include <chasles/base/error.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/lie/so3.hpp>

// States that leave the filter, and return (docs/map.md).

namespace chasles {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Three rows become a linear function of some rows, their own among them.
void Ekf::substitute(int row, std::span<const RowTerm> terms) {
  auto P = covariance_.all();
  Eigen::Matrix<double, 3, Eigen::Dynamic> rows =
      Eigen::Matrix<double, 3, Eigen::Dynamic>::Zero(3, P.cols());
  for (const RowTerm& term : terms) rows += term.d * P.middleRows<3>(term.row);
  P.middleRows<3>(row) = rows;
  Eigen::Matrix<double, Eigen::Dynamic, 3> columns =
      Eigen::Matrix<double, Eigen::Dynamic, 3>::Zero(P.rows(), 3);
  for (const RowTerm& term : terms) columns += P.middleCols<3>(term.row) * term.d.transpose();
  P.middleCols<3>(row) = columns;
  if (latest_.variables() > 0) {
    Eigen::Matrix<double, Eigen::Dynamic, 3> with_latest =
        Eigen::Matrix<double, Eigen::Dynamic, 3>::Zero(latest_.variables(), 3);
    for (const RowTerm& term : terms) {
      with_latest += latest_.Z().middleCols<3>(term.row) * term.d.transpose();
    }
    latest_.Z().middleCols<3>(row) = with_latest;
  }
  const Matrix3d own = P.block<3, 3>(row, row);
  P.block<3, 3>(row, row) = (own + own.transpose()) / 2;
}

// A past landmark is Cartesian, in nav axes where nav_T_world is a state: composition then does not
// concern it.
void Ekf::to_map_axes(Landmark& landmark) {
  if (!state_.nav_T_world) return;
  const SE3& nav_T_world = *state_.nav_T_world;
  const Vector3d arm = nav_T_world.R * landmark.p_world;
  const int nav = state_.nav_row();
  const RowTerm terms[] = {
      {landmark.row, nav_T_world.R}, {nav, -hat(arm)}, {nav + 3, Matrix3d::Identity()}};
  substitute(landmark.row, terms);
  landmark.p_world = nav_T_world * landmark.p_world;
  landmark.first = nav_T_world * landmark.first;
}

void Ekf::to_world_axes(Landmark& landmark) {
  if (!state_.nav_T_world) return;
  const SE3 world_T_nav = state_.nav_T_world->inverse();
  const Matrix3d& R = world_T_nav.R;
  const int nav = state_.nav_row();
  const RowTerm terms[] = {
      {landmark.row, R}, {nav, R * hat(landmark.p_world - state_.nav_T_world->p)}, {nav + 3, -R}};
  substitute(landmark.row, terms);
  landmark.p_world = world_T_nav * landmark.p_world;
  landmark.first = world_T_nav * landmark.first;
}

void Ekf::leave(std::span<const int> indices) {
  for (const int index : indices) {
    Landmark& landmark = state_.landmarks[static_cast<std::size_t>(index)];
    if (!landmark.has_place()) continue;
    make_cartesian(index);
    to_map_axes(landmark);
    if (landmark.considered) {
      past_.note_left(*landmark.considered);
      state_.considered->away.push_back(landmark);
      continue;
    }
    const auto P = covariance_.all();
    latest_.add_item({.number = past_.add(landmark), .size = 3}, P.middleRows<3>(landmark.row),
                     P.block<3, 3>(landmark.row, landmark.row),
                     latest_.Z().middleCols<3>(landmark.row));
  }
  for (auto index = indices.rbegin(); index != indices.rend(); ++index) {
    state_.landmarks.erase(state_.landmarks.begin() + *index);
  }
  keep_rows();
}

void Ekf::remove(std::span<const int> indices) {
  if (remembers()) throw UsageError("landmarks are not removed from a filter with Map::kHistory");
  for (auto index = indices.rbegin(); index != indices.rend(); ++index) {
    state_.landmarks.erase(state_.landmarks.begin() + *index);
  }
  keep_rows();
}

void Ekf::remember_pose(Time time) {
  if (remembers()) {
    history_.append(History::Pose{.time = time, .world_T_imu = state_.world_T_imu});
    return;
  }
  remember_pose(time, state_.world_T_imu, MatrixXd::Identity(6, state_.core_size()));
}

void Ekf::remember_pose(Time time, const SE3& map_T_imu, const MatrixXd& d_core) {
  if (!has_past()) throw UsageError("past poses need a filter with Map::kPast");
  const Index n = d_core.cols();
  const MatrixXd with_state = d_core * covariance_.all().topRows(n);
  latest_.add_item({.number = past_.add(time, map_T_imu), .size = 6}, with_state,
                   with_state.leftCols(n) * d_core.transpose(),
                   latest_.Z().leftCols(n) * d_core.transpose());
}

// Ending a segment costs little. A segment's steps cost the more the more states have left in it.
void Ekf::end_segment_when_due() {
  constexpr Index kMostRows = 120;
  if (latest_.item_rows() < kMostRows) return;
  past_.append(latest_.segment());
  latest_.begin(covariance_.size());
}

Carried Ekf::recall(std::span<const int> numbers) const {
  const auto [others, considered] = apart(numbers);
  const std::vector<int> sources = past_.sources(others);
  Carried past = past_.recall(sources);
  carry(past, latest_.segment(), sources);
  past = past_.derived(past, others);
  return considered.empty() ? past : recall_considered(considered, past);
}

void Ekf::marginalise(std::span<const int> numbers) {
  for (const int number : numbers) {
    past_.marginalise(number);
    if (is_considered(number)) drop_considered(number);
  }
}

// The past states become the last rows of the state.
void Ekf::revive(std::span<const int> numbers) {
  if (!has_past()) throw UsageError("landmarks return in a filter with Map::kPast alone");
  if (numbers.empty()) return;
  const auto [list, considered] = apart(numbers);
  if (!std::ranges::all_of(numbers, [&](int number) { return past_.can_return(number); })) {
    throw UsageError(
        "a landmark cannot return: expected past.recalls, and numbers of past landmarks that have "
        "not returned");
  }
  revive_considered(considered);
  if (list.empty()) return;
  Carried past;
  if (options_.map == Map::kDense) {
    carry(past, latest_.segment(), list);
    past_.note_returned(list);
  } else {
    past_.append(latest_.segment());
    past = past_.revive(list);
    latest_.clear(covariance_.size());
  }
  const auto k = static_cast<int>(past.rows());
  const int row = covariance_.append(k);
  auto P = covariance_.all();
  P.block(row, 0, k, row) = past.C;
  P.block(0, row, row, k) = past.C.transpose();
  P.bottomRightCorner(k, k) = past.P;
  const std::size_t first = state_.landmarks.size();
  for (std::size_t i = 0; i < list.size(); ++i) {
    Landmark landmark = past_.landmark(list[i]);
    landmark.row = row + 3 * static_cast<int>(i);
    landmark.p_world += past.correction.segment<3>(3 * static_cast<Index>(i));
    state_.landmarks.push_back(landmark);
  }
  if (options_.map == Map::kDense) {
    latest_.make_states(list);
  } else {
    latest_.begin(covariance_.size());  // first, so that the segment contains what follows
  }
  const std::optional<VectorXd> scale =
      options_.keep_scale ? scale_error({state_.landmarks.data(), first}) : std::nullopt;
  for (std::size_t i = 0; i < list.size(); ++i) {
    Landmark& landmark = state_.landmarks[first + i];
    move_to_present_mean(past_.landmark(list[i]).p_world, landmark, scale);
    to_world_axes(landmark);
  }
}

// The mean of a past landmark has moved, but its errors have not taken part in the changes of the
// chart (docs/charts.md) and of the scale (docs/filter.md) that came with it. They do so here, in
// one step, so that what no measurement observes stays unobserved. Nav axes have no such changes.
void Ekf::move_to_present_mean(const Vector3d& as_it_left, const Landmark& landmark,
                               const std::optional<VectorXd>& scale) {
  if (state_.nav_T_world) return;
  if (chart_->landmark_block) {
    const Matrix3d turn =
        chart_->landmark_block(as_it_left) - chart_->landmark_block(landmark.p_world);
    const RowTerm terms[] = {{landmark.row, Matrix3d::Identity()}, {0, turn}};
    substitute(landmark.row, terms);
  }
  if (scale) {
    const Vector3d by = landmark.p_world - as_it_left;
    auto P = covariance_.all();
    const VectorXd before = P * *scale;
    P.middleRows<3>(landmark.row) += by * before.transpose();
    const VectorXd after = P * *scale;
    P.middleCols<3>(landmark.row) += after * by.transpose();
    const VectorXd with_latest = latest_.Z() * *scale;
    latest_.Z().middleCols<3>(landmark.row) += with_latest * by.transpose();
  }
}

// Of a landmark of the state, by all errors.
Eigen::Matrix<double, 3, Eigen::Dynamic> Ekf::derivative_in_map_axes(
    const Landmark& landmark) const {
  using Rows = Eigen::Matrix<double, 3, Eigen::Dynamic>;
  const Matrix3d R = state_.nav_T_world ? state_.nav_T_world->R : Matrix3d::Identity();
  Rows d = Rows::Zero(3, covariance_.size());
  if (landmark.anchor) {
    const Clone& clone = state_.clone(*landmark.anchor);
    const Eigen::Matrix<double, 3, 9> J = R * anchored_derivative(clone, landmark);
    d.middleCols<6>(clone.row) = J.leftCols<6>();
    d.middleCols<3>(landmark.row) = J.rightCols<3>();
    if (const auto camera = state_.camera_row(landmark.camera)) {
      d.middleCols<6>(*camera) = R * anchored_derivative_by_camera(clone, landmark);
    }
  } else {
    d.middleCols<3>(landmark.row) = R;
  }
  if (state_.nav_T_world) {
    const int nav = state_.nav_row();
    d.middleCols<3>(nav) = -hat(R * state_.p_world(landmark));
    d.middleCols<3>(nav + 3).setIdentity();
  }
  return d;
}

// A landmark of the state in the map's axes, with the errors of these.
MapLandmark Ekf::in_map_axes(const Landmark& landmark) const {
  MapLandmark result = as_of_now(landmark);
  if (!state_.nav_T_world) return result;
  const auto d = derivative_in_map_axes(landmark);
  result.p_world = *state_.nav_T_world * result.p_world;
  result.covariance = d * covariance_.all() * d.transpose();
  return result;
}

void Ekf::check_fits(const PriorMap& prior) const {
  if (!has_past() || !options_.past.recalls) {
    throw UsageError("a prior map needs a filter with Map::kPast and past.recalls");
  }
  const auto landmarks = static_cast<Index>(prior.landmarks.size());
  if (prior.shared.rows() != 6 + 3 * landmarks || prior.own.size() != prior.landmarks.size()) {
    throw UsageError("a prior map has six rows of shared errors, and three for each landmark");
  }
}

int Ekf::add_past(PriorMap prior) {
  check_fits(prior);
  const Index n = covariance_.size(), r = prior.shared.cols();
  if (options_.map == Map::kDense) {
    add_dense(prior);
    return past_.add(std::move(prior), true);
  }
  past_.append(latest_.segment());
  const int frame = past_.add(std::move(prior));
  Segment segment{.starts = n,
                  .items = {{.number = frame, .size = static_cast<int>(r)}},
                  .X = MatrixXd::Identity(n, n + r),
                  .G = MatrixXd::Zero(n + r, n + r),
                  .g = VectorXd::Zero(n + r)};
  segment.G.bottomRightCorner(r, r).setIdentity();
  past_.append(std::move(segment));
  latest_.begin(n);
  return frame;
}

// All landmarks as items.
void Ekf::add_dense(const PriorMap& prior) {
  const Index n = covariance_.size(), r = prior.shared.cols();
  const int frame = past_.states();
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

Carried Ekf::recall(std::span<const int> numbers, std::span<const int> landmarks) const {
  Carried result = recall(numbers);
  const Index n = covariance_.size(), k = result.rows(),
              m = 3 * static_cast<Index>(landmarks.size());
  if (k == 0) result.C.resize(0, n);
  MatrixXd d(m, n);
  VectorXd correction(k + m);
  correction.head(k) = result.correction;
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const Landmark& landmark = state_.landmarks[static_cast<std::size_t>(landmarks[i])];
    const Index at = 3 * static_cast<Index>(i);
    d.middleRows<3>(at) = derivative_in_map_axes(landmark);
    const Vector3d p_world = state_.p_world(landmark);
    correction.segment<3>(k + at) = state_.nav_T_world ? *state_.nav_T_world * p_world : p_world;
    result.items.push_back({.number = -1, .size = 3});
  }
  const MatrixXd P_all = covariance_.all(), d_transposed = d.transpose();
  MatrixXd C(k + m, n), P(k + m, k + m);
  C << result.C, dense::product(d, P_all);
  P.topLeftCorner(k, k) = result.P;
  P.rightCols(m) = dense::product(C, d_transposed);
  P.bottomLeftCorner(m, k) = P.topRightCorner(k, m).transpose();
  result.C = std::move(C);
  result.P = std::move(P);
  result.correction = std::move(correction);
  return result;
}

void Ekf::visit_dense_covariance(const History::RowVisitor& visit) const {
  std::vector<int> landmarks;
  for (const Segment::Item& item : latest_.items()) {
    if (item.size == 3) landmarks.push_back(item.number);
  }
  const Segment past = with_items(latest_.segment(), landmarks);
  const Index q = past.g.size(), n = covariance_.size();
  std::vector<int> rows;
  const auto take = [&](int first, int size) {
    for (int i = 0; i < size; ++i) rows.push_back(first + i);
  };
  for (const Landmark& landmark : state_.landmarks) take(landmark.row, 3);
  take(0, state_.core_size());
  MatrixXd whole(q + n, q + n);
  whole << past.G, past.X(rows, Eigen::all).transpose(), past.X(rows, Eigen::all),
      covariance_.all()(rows, rows);
  visit(0, whole);
}

Past::Estimates Ekf::past_estimates() const {
  Past::Estimates result = has_past() ? past_.estimates(latest_.segment()) : history_.estimates();
  if (state_.considered) append_considered(result);
  result.landmarks.insert(result.landmarks.end(), frozen_.begin(), frozen_.end());
  for (const Landmark& landmark : state_.landmarks) {
    if (!landmark.has_place()) continue;
    result.landmarks.push_back(has_past() ? in_map_axes(landmark) : as_of_now(landmark));
  }
  return result;
}

}  // namespace chasles
