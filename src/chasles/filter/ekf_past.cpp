#include <algorithm>
#include <optional>
#include <utility>

#include <chasles/error.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/lie/so3.hpp>

// States that leave the filter, and return (docs/map.md). Their rows stay in the covariance until
// the end of a segment, so that every step of the filter moves them too. With the rows of the
// state at the segment's beginning, which are kept likewise, the covariance then contains the
// segment.

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

void append_rows(std::vector<int>& rows, int first, int count) {
  for (int i = 0; i < count; ++i) rows.push_back(first + i);
}

}  // namespace

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
  const RowTerm terms[] = {{landmark.row, nav_T_world.R},
                           {nav, -hat(arm)},
                           {nav + 3, Matrix3d::Identity()}};
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
    leavers_.push_back({.number = past_.add(landmark),
                        .row = landmark.row,
                        .size = 3,
                        .correction = VectorXd::Zero(3)});
  }
  for (auto index = indices.rbegin(); index != indices.rend(); ++index) {
    state_.landmarks.erase(state_.landmarks.begin() + *index);
  }
  covariance_.keep(renumber_rows());
}

void Ekf::remember_pose(Time time, const SE3& map_T_imu, const MatrixXd& d_core) {
  if (!has_past()) throw UsageError("past poses need a filter with Map::kPast");
  const int row = covariance_.append(6);
  auto P = covariance_.all();
  const MatrixXd cross = d_core * P.topLeftCorner(d_core.cols(), row);
  P.block(row, 0, 6, row) = cross;
  P.block(0, row, row, 6) = cross.transpose();
  P.block<6, 6>(row, row) = cross.leftCols(d_core.cols()) * d_core.transpose();
  leavers_.push_back({.number = past_.add(time, map_T_imu),
                      .row = row,
                      .size = 6,
                      .correction = VectorXd::Zero(6)});
}

// All rows of the state.
std::vector<int> Ekf::state_rows() const {
  std::vector<int> rows;
  append_rows(rows, 0, state_.core_size());
  for (const Landmark& landmark : state_.landmarks) append_rows(rows, landmark.row, 3);
  for (const Clone& clone : state_.clones) append_rows(rows, clone.row, 6);
  std::ranges::sort(rows);
  return rows;
}

MatrixXd Ekf::state_covariance() const {
  const std::vector<int> rows = state_rows();
  return covariance_.all()(rows, rows);
}

Segment Ekf::latest_segment() const {
  Segment segment;
  std::vector<int> variables;
  if (starts_) {
    segment.starts = starts_->size;
    append_rows(variables, starts_->row, starts_->size);
  }
  for (const Kept& past : leavers_) {
    segment.items.push_back({.number = past.number, .size = past.size});
    append_rows(variables, past.row, past.size);
  }
  segment.X = covariance_.all()(state_rows(), variables);
  segment.G = covariance_.all()(variables, variables);
  segment.g.resize(static_cast<Index>(variables.size()));
  Index at = segment.starts;
  if (starts_) segment.g.head(at) = starts_->correction;
  for (const Kept& past : leavers_) {
    segment.g.segment(at, past.size) = past.correction;
    at += past.size;
  }
  return segment;
}

void Ekf::end_segment() {
  past_.append(latest_segment());
  starts_.reset();
  leavers_.clear();
  covariance_.keep(renumber_rows());
}

// The rows that are kept have the unit covariance with those of the state, and none with each
// other: what becomes of them is a factor on any true cross-covariance.
void Ekf::begin_segment() {
  const int n = covariance_.size();
  starts_ = Kept{.row = covariance_.append(n), .size = n, .correction = VectorXd::Zero(n)};
  auto P = covariance_.all();
  P.bottomLeftCorner(n, n).setIdentity();
  P.topRightCorner(n, n).setIdentity();
}

// The rows of those who left take part in every step. Ending a segment costs a copy of its rows.
void Ekf::end_segment_when_due() {
  constexpr int kMostRows = 120;
  int rows = 0;
  for (const Kept& past : leavers_) rows += past.size;
  if (rows < kMostRows) return;
  end_segment();
  begin_segment();
}

// With Map::kDense their rows are there already.
std::vector<Landmark> Ekf::rows_that_return(const std::vector<int>& numbers) {
  std::vector<Landmark> result;
  for (const int number : numbers) {
    const auto past = std::ranges::find(leavers_, number, &Kept::number);
    const int row = covariance_.append(3);
    auto P = covariance_.all();
    P.middleRows<3>(row) = P.middleRows<3>(past->row);
    P.middleCols<3>(row) = P.middleCols<3>(past->row);
    result.push_back(past_.landmark(number));
    result.back().row = row;
    result.back().p_world += past->correction;
  }
  std::erase_if(leavers_, [&](const Kept& past) {
    return std::ranges::find(numbers, past.number) != numbers.end();
  });
  past_.note_returned(numbers);
  return result;
}

std::vector<Landmark> Ekf::recalled_rows(const std::vector<int>& numbers) {
  const Carried past = past_.revive(numbers);
  const auto k = past.rows();
  const int row = covariance_.append(static_cast<int>(k));
  auto P = covariance_.all();
  P.block(row, 0, k, row) = past.C;
  P.block(0, row, row, k) = past.C.transpose();
  P.bottomRightCorner(k, k) = past.P;
  std::vector<Landmark> result;
  int at = 0;
  for (const Segment::Item& item : past.items) {
    result.push_back(past_.landmark(item.number));
    result.back().row = row + at;
    result.back().p_world += past.correction.segment<3>(at);
    at += item.size;
  }
  return result;
}

void Ekf::revive(std::span<const int> numbers) {
  if (numbers.empty()) return;
  const std::vector<int> list(numbers.begin(), numbers.end());
  const bool dense = options_.map == Map::kDense;
  if (!dense) end_segment();
  const std::vector<Landmark> returning = dense ? rows_that_return(list) : recalled_rows(list);
  const std::size_t first = state_.landmarks.size();
  state_.landmarks.insert(state_.landmarks.end(), returning.begin(), returning.end());
  if (dense) {
    covariance_.keep(renumber_rows());
  } else {
    begin_segment();  // first, so that the segment contains the changes that follow
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
  }
}

// A landmark of the state in the map's axes, with the errors of these.
MapLandmark Ekf::in_map_axes(const Landmark& landmark) const {
  MapLandmark result = as_of_now(landmark);
  if (!state_.nav_T_world) return result;
  using Rows = Eigen::Matrix<double, 3, Eigen::Dynamic>;
  const Matrix3d& R = state_.nav_T_world->R;
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
  const int nav = state_.nav_row();
  d.middleCols<3>(nav) = -hat(R * result.p_world);
  d.middleCols<3>(nav + 3).setIdentity();
  result.p_world = *state_.nav_T_world * result.p_world;
  result.covariance = d * covariance_.all() * d.transpose();
  return result;
}

Past::Estimates Ekf::past_estimates() const {
  if (!has_past()) throw UsageError("past estimates need a filter with Map::kPast");
  Past::Estimates result = past_.estimates(latest_segment());
  for (const Landmark& landmark : state_.landmarks) {
    if (landmark.has_place()) result.landmarks.push_back(in_map_axes(landmark));
  }
  return result;
}

}  // namespace chasles
