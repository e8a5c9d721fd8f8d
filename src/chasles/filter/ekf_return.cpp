#include <optional>
#include <utility>
#include <vector>

#include <chasles/filter/considered_map.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/lie/so3.hpp>

// Past landmarks that return into the state, and the axes of the map (docs/map.md).

namespace chasles {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using RowTerm = KeptPast::RowTerm;

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
  past_.substitute(row, terms);
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

int Ekf::add_past(PriorMap prior) { return past_.add_past(std::move(prior), covariance_); }

void Ekf::revive(std::span<const int> numbers) {
  past_.check_can_return(numbers);
  const auto [others, considered] = apart_from_considered(state_, past_.left(), numbers);
  if (!considered.empty()) revive_considered(considered);
  if (!others.empty()) revive_others(others);
}

// The past states become the last rows of the state.
void Ekf::revive_others(const std::vector<int>& numbers) {
  const Carried past = past_.revive(numbers, covariance_);
  const auto k = static_cast<int>(past.rows());
  const int row = covariance_.append(k);
  auto P = covariance_.all();
  P.block(row, 0, k, row) = past.C;
  P.block(0, row, row, k) = past.C.transpose();
  P.bottomRightCorner(k, k) = past.P;
  std::vector<Vector3d> as_they_left;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    Landmark landmark = past_.left().landmark(numbers[i]);
    as_they_left.push_back(landmark.p_world);
    landmark.row = row + 3 * static_cast<int>(i);
    landmark.p_world += past.correction.segment<3>(3 * static_cast<Index>(i));
    state_.landmarks.push_back(landmark);
  }
  follow_the_changes(as_they_left);
}

// The last landmarks of the state.
void Ekf::follow_the_changes(std::span<const Vector3d> as_they_left) {
  const std::size_t first = state_.landmarks.size() - as_they_left.size();
  const std::optional<VectorXd> scale =
      keep_scale_ ? scale_error({state_.landmarks.data(), first}) : std::nullopt;
  for (std::size_t i = 0; i < as_they_left.size(); ++i) {
    Landmark& landmark = state_.landmarks[first + i];
    move_to_present_mean(as_they_left[i], landmark, scale);
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
    past_.add_along(*scale, landmark.row, by);
  }
}

}  // namespace chasles
