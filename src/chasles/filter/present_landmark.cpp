#include <chasles/filter/present_landmark.hpp>
#include <chasles/lie/small_matrices.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {

using Eigen::Matrix3d;

MapLandmark as_of_now(const State& x, const Covariance& covariance, const Landmark& landmark) {
  const auto P = covariance.all();
  MapLandmark result{.id = landmark.id,
                     .p_world = x.p_world(landmark),
                     .covariance = P.block<3, 3>(landmark.row, landmark.row),
                     .observations = landmark.observations};
  if (!landmark.anchor) return result;
  const Clone& clone = x.clone(*landmark.anchor);
  Eigen::Matrix<double, 3, 9> J;
  J << anchored_derivative(clone, landmark);
  Eigen::Matrix<double, 9, 9> block;
  block.topLeftCorner<6, 6>() = P.block<6, 6>(clone.row, clone.row);
  block.bottomRightCorner<3, 3>() = P.block<3, 3>(landmark.row, landmark.row);
  block.bottomLeftCorner<3, 6>() = P.block<3, 6>(landmark.row, clone.row);
  block.topRightCorner<6, 3>() = block.bottomLeftCorner<3, 6>().transpose();
  result.covariance = congruence(J, block);
  if (const auto camera = x.camera_row(landmark.camera)) {
    const auto J_camera = anchored_derivative_by_camera(clone, landmark);
    const Matrix3d cross = (J.leftCols<6>() * P.block<6, 6>(clone.row, *camera) +
                            J.rightCols<3>() * P.block<3, 6>(landmark.row, *camera)) *
                           J_camera.transpose();
    result.covariance += cross + cross.transpose() +
                         J_camera * P.block<6, 6>(*camera, *camera) * J_camera.transpose();
  }
  return result;
}

Eigen::Matrix<double, 3, Eigen::Dynamic> derivative_in_map_axes(const State& x,
                                                                const Landmark& landmark,
                                                                Eigen::Index size) {
  using Rows = Eigen::Matrix<double, 3, Eigen::Dynamic>;
  const Matrix3d R = x.nav_T_world ? x.nav_T_world->R : Matrix3d::Identity();
  Rows d = Rows::Zero(3, size);
  if (landmark.anchor) {
    const Clone& clone = x.clone(*landmark.anchor);
    const Eigen::Matrix<double, 3, 9> J = R * anchored_derivative(clone, landmark);
    d.middleCols<6>(clone.row) = J.leftCols<6>();
    d.middleCols<3>(landmark.row) = J.rightCols<3>();
    if (const auto camera = x.camera_row(landmark.camera)) {
      d.middleCols<6>(*camera) = R * anchored_derivative_by_camera(clone, landmark);
    }
  } else {
    d.middleCols<3>(landmark.row) = R;
  }
  if (x.nav_T_world) {
    const int nav = x.nav_row();
    d.middleCols<3>(nav) = -hat(R * x.p_world(landmark));
    d.middleCols<3>(nav + 3).setIdentity();
  }
  return d;
}

MapLandmark in_map_axes(const State& x, const Covariance& covariance, const Landmark& landmark) {
  MapLandmark result = as_of_now(x, covariance, landmark);
  if (!x.nav_T_world) return result;
  const auto d = derivative_in_map_axes(x, landmark, covariance.size());
  result.p_world = *x.nav_T_world * result.p_world;
  result.covariance = d * covariance.all() * d.transpose();
  return result;
}

}  // namespace chasles
