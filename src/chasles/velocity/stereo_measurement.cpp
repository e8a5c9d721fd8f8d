#include <chasles/velocity/stereo_measurement.hpp>

namespace chasles {

Eigen::Matrix<double, Eigen::Dynamic, 4, 0, 4, 4> rows_of(StereoRows rows) {
  if (rows == StereoRows::kAll) return Eigen::Matrix4d::Identity();
  Eigen::Matrix<double, Eigen::Dynamic, 4, 0, 4, 4> A(rows == StereoRows::kMean ? 2 : 3, 4);
  A.row(0) << 0.5, 0, 0.5, 0;
  A.row(1) << 0, 0.5, 0, 0.5;
  if (rows == StereoRows::kMeanDisparity) A.row(2) << 1, 0, -1, 0;
  return A;
}

Eigen::Vector4d variances_of(StereoRows rows, const StereoNoise& noise) {
  const double u2 = noise.u * noise.u;
  const double v2 = noise.v * noise.v;
  if (rows == StereoRows::kAll) return {u2, v2, u2, v2};
  return {u2, v2, noise.disparity * noise.disparity, 0};
}

std::optional<Measurement> measure_stereo(const StereoRig& rig, StereoRows rows,
                                          const StereoNoise& noise, const State& x, int index,
                                          const StereoObservation& observation) {
  const Eigen::Vector3d& p_world = x.landmarks[static_cast<std::size_t>(index)].p_world;
  const Eigen::Matrix3d cam0_R_world = rig.cam0_T_imu.R * x.world_T_imu.R.transpose();
  const Eigen::Vector3d from_imu_world = p_world - x.world_T_imu.p;
  const auto projection = project(rig, cam0_R_world * from_imu_world + rig.cam0_T_imu.p);
  if (!projection) return std::nullopt;

  const auto A = rows_of(rows);
  Measurement result;
  result.landmark = index;
  result.residual = A * (observation.pixels - projection->pixels);
  // docs/derivations.md, D38: d y_b = C^T (dY - dp + [Y - p] theta)
  result.d_landmark = A * projection->d_point * cam0_R_world;
  result.d_core.resize(A.rows(), 6);
  result.d_core.leftCols<3>() = result.d_landmark * hat(from_imu_world);
  result.d_core.rightCols<3>() = -result.d_landmark;
  result.noise = variances_of(rows, noise).head(A.rows()).asDiagonal();
  return result;
}

std::optional<NewLandmark> initialise_landmark(const StereoRig& rig, const StereoNoise& noise,
                                               const State& x,
                                               const StereoObservation& observation) {
  const auto point = triangulate(rig, observation.pixels);
  if (!point) return std::nullopt;
  // Pixels from the three independent numbers (mean u, mean v, disparity), and so the point.
  Eigen::Matrix<double, 4, 3> pixels_by_rows;
  pixels_by_rows << 1, 0, 0.5, 0, 1, 0, 1, 0, -0.5, 0, 1, 0;
  const Eigen::Matrix3d imu_R_cam0 = rig.cam0_T_imu.R.transpose();
  const Eigen::Vector3d p_imu = imu_R_cam0 * (point->p_cam0 - rig.cam0_T_imu.p);
  const Eigen::Matrix3d d_rows = x.world_T_imu.R * imu_R_cam0 * point->d_pixels * pixels_by_rows;
  const Eigen::Vector3d sigma(noise.u, noise.v, noise.disparity);

  NewLandmark result;
  result.id = observation.landmark;
  result.p_world = x.world_T_imu * p_imu;
  result.d_pose.leftCols<3>() = -hat(x.world_T_imu.R * p_imu);
  result.d_pose.rightCols<3>().setIdentity();
  result.noise = d_rows * sigma.cwiseAbs2().asDiagonal() * d_rows.transpose();
  return result;
}

}  // namespace chasles
