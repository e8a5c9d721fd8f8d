#include <algorithm>
#include <cmath>

#include <chasles/base/error.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/filter/ekf.hpp>

// Clones, and the change of the world frame (docs/derivations.md, D51 and D52).

namespace chasles {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void Ekf::clone_pose(int id, Time time) {
  past_.reject_with_history("clones need");
  const int row = covariance_.append(6);
  auto P = covariance_.all();
  P.block(row, 0, 6, row) = P.topLeftCorner(6, row);
  P.block(0, row, row, 6) = P.topLeftCorner(row, 6);
  P.block<6, 6>(row, row) = P.topLeftCorner<6, 6>();
  past_.clone_pose();
  state_.clones.push_back({.id = id,
                           .time = time,
                           .world_T_imu = state_.world_T_imu,
                           .row = row,
                           .first = state_.world_T_imu,
                           .readout = state_.readout});
}

void Ekf::remove_clones(std::span<const int> ids) {
  if (ids.empty()) return;
  std::erase_if(state_.clones, [&](const Clone& clone) {
    return std::find(ids.begin(), ids.end(), clone.id) != ids.end();
  });
  keep_rows();
}

void Ekf::make_cartesian(int index) {
  Landmark& landmark = state_.landmarks[static_cast<std::size_t>(index)];
  if (!landmark.anchor) return;
  const Clone& clone = state_.clone(*landmark.anchor);
  const Eigen::Matrix<double, 3, 9> J = anchored_derivative(clone, landmark);
  auto P = covariance_.all();
  using Rows = Eigen::Matrix<double, 3, Eigen::Dynamic>;
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3>;
  auto rows = work_.product.take<Rows>(3, P.cols());
  auto more_rows = work_.other.take<Rows>(3, P.cols());
  rows.noalias() = J.leftCols<6>() * P.middleRows<6>(clone.row);
  more_rows.noalias() = J.rightCols<3>() * P.middleRows<3>(landmark.row);
  P.middleRows<3>(landmark.row) = rows + more_rows;
  const auto camera = state_.camera_row(landmark.camera);
  const auto J_camera = anchored_derivative_by_camera(clone, landmark);
  if (camera) {
    more_rows.noalias() = J_camera * P.middleRows<6>(*camera);
    P.middleRows<3>(landmark.row) += more_rows;
  }
  auto columns = work_.product.take<Columns>(P.rows(), 3);
  auto more_columns = work_.other.take<Columns>(P.rows(), 3);
  columns.noalias() = P.middleCols<6>(clone.row) * J.leftCols<6>().transpose();
  more_columns.noalias() = P.middleCols<3>(landmark.row) * J.rightCols<3>().transpose();
  columns += more_columns;
  if (camera) {
    more_columns.noalias() = P.middleCols<6>(*camera) * J_camera.transpose();
    columns += more_columns;
  }
  P.middleCols<3>(landmark.row) = columns;
  past_.make_cartesian(landmark.row, clone.row, J, camera, J_camera);
  const Matrix3d own = P.block<3, 3>(landmark.row, landmark.row);
  P.block<3, 3>(landmark.row, landmark.row) = (own + own.transpose()) / 2;
  landmark.p_world = state_.p_world(landmark);
  landmark.anchor.reset();
}

double Ekf::inverse_depth_sigma(const Landmark& landmark) const {
  const int row = landmark.row + 2;
  return std::sqrt(covariance_.all()(row, row));
}

void Ekf::compose() {
  past_.reject_with_history("composition needs");
  if (!state_.nav_T_world) throw UsageError("composition needs nav_T_world in the state");
  const SE3 imu_T_world = state_.world_T_imu.inverse();
  const Matrix3d Rt = imu_T_world.R;
  const Vector3d p = state_.world_T_imu.p;
  auto J = work_.B.take(covariance_.size(), covariance_.size());
  J.setIdentity();
  J.topRows<6>().setZero();
  // A point x of the world goes to R^T (x - p), a velocity v to R^T v.
  const auto move = [&](int row, const Vector3d& x, bool is_point) {
    J.block<3, 3>(row, 0) = Rt * hat(is_point ? Vector3d(x - p) : x);
    if (is_point) J.block<3, 3>(row, 3) = -Rt;
    J.block<3, 3>(row, row) = Rt;
  };
  if (state_.v_world) {
    move(6, *state_.v_world, false);
    state_.v_world = Rt * *state_.v_world;
  }
  for (Landmark& landmark : state_.landmarks) {
    landmark.first = imu_T_world * landmark.first;
    if (landmark.anchor) continue;
    move(landmark.row, landmark.p_world, true);
    landmark.p_world = imu_T_world * landmark.p_world;
  }
  for (Clone& clone : state_.clones) {
    J.block<3, 3>(clone.row, 0) = -Rt;
    J.block<3, 3>(clone.row, clone.row) = Rt;
    move(clone.row + 3, clone.world_T_imu.p, true);
    clone.world_T_imu = imu_T_world * clone.world_T_imu;
    clone.first = imu_T_world * clone.first;
  }
  const int nav = state_.nav_row();
  const Matrix3d nav_R_world = state_.nav_T_world->R;
  J.block<3, 3>(nav, 0) = nav_R_world;
  J.block<3, 3>(nav + 3, 3) = nav_R_world;
  J.block<3, 3>(nav + 3, nav) = -hat(nav_R_world * p);
  state_.nav_T_world = *state_.nav_T_world * state_.world_T_imu;
  state_.nav_T_world->R = so3::normalized(state_.nav_T_world->R);
  state_.world_T_imu = {};
  auto P = covariance_.all();
  auto JP = work_.product.take(J.rows(), J.cols());
  dense::multiply(J, P, JP);
  auto J_transposed = work_.other.take(J.rows(), J.cols());
  J_transposed = J.transpose();
  dense::multiply(JP, J_transposed, P);
  dense::mirror_lower(P);
  past_.compose(imu_T_world, J_transposed);
}

}  // namespace chasles
