#include <Eigen/LU>

#include <chasles/filter/calibration.hpp>
#include <chasles/filter/pixel_measurement.hpp>
#include <chasles/filter/pixel_projection.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Far off the axis, a pixel's angle may differ much from that on the axis: the noise of the two
// coordinates of a ray in its face, from that of the pixel. None where the lens has no pixel.
std::optional<Matrix3d> noise_beside(const Camera& camera, const Landmark& landmark,
                                     double variance) {
  const Matrix3d cam_R_face = face_R_cam(landmark.face).transpose();
  const Vector3d ray =
      cam_R_face * Vector3d(landmark.inverse_depth.x(), landmark.inverse_depth.y(), 1);
  const auto seen = project(camera, ray);
  if (!seen) return std::nullopt;
  const Eigen::Matrix2d d_xy = (seen->d_point * cam_R_face.leftCols<2>()).inverse();
  Matrix3d noise = Matrix3d::Zero();
  noise.topLeftCorner<2, 2>() = variance * d_xy * d_xy.transpose();
  return noise;
}

}  // namespace

std::optional<Measurement> measure_pixel(const Camera& known, double sigma, const State& x,
                                         int number, const Vector2d& pixel, Linearisation at,
                                         int index) {
  Measurement z;
  if (!measure_pixel(known, sigma, x, number, pixel, at, index, z)) return std::nullopt;
  return z;
}

bool measure_pixel(const Camera& known, double sigma, const State& x, int number,
                   const Vector2d& pixel, Linearisation at, int index, Measurement& z) {
  constexpr std::size_t kMostOthers = 6;  // the anchor, its camera, this one and its intrinsics
  const Camera camera = as_estimated(known, x, index, pixel);
  const Landmark& landmark = x.landmarks[static_cast<std::size_t>(number)];
  const bool first = at == Linearisation::kFirstEstimates;
  const HomogeneousPoint point = x.homogeneous(landmark);
  const auto now = see(camera, x.world_T_imu, point, pixel);
  // The parameters of an anchored landmark may be arbitrary at first: only the poses use first
  // estimates.
  Clone anchor;
  if (landmark.anchor) anchor = x.clone(*landmark.anchor);
  if (first) anchor.world_T_imu = anchor.first;
  const HomogeneousPoint at_point = !first            ? point
                                    : landmark.anchor ? homogeneous(anchor, landmark)
                                                      : HomogeneousPoint{landmark.first};
  const auto seen = first ? see(camera, x.world_T_imu, at_point, pixel) : now;
  if (!now || !seen) return false;
  z.clear();
  z.clones.reserve(kMostOthers);
  z.landmark = number;
  z.residual = now->residual;
  z.d_core = seen->d_pose;
  z.d_landmark = seen->d_point;
  z.noise = sigma * sigma * Eigen::Matrix2d::Identity();
  if (landmark.anchor) {
    const Eigen::Matrix<double, 3, 9> d = homogeneous_derivative(anchor, landmark);
    z.clones.push_back({.row = anchor.row, .d = seen->d_point * d.leftCols<6>()});
    z.d_landmark = seen->d_point * d.rightCols<3>();
    z.d_landmark.rightCols<1>() += seen->d_w;
    if (const auto row = x.camera_row(landmark.camera)) {
      z.clones.push_back(
          {.row = *row, .d = seen->d_point * homogeneous_derivative_by_camera(anchor, landmark)});
    }
  }
  if (const auto row = x.camera_row(index)) {
    z.clones.push_back({.row = *row,
                        .d = derivative_by_camera(camera, x.world_T_imu, at_point, seen->d_point,
                                                  imu_T_line(camera, x.readout, pixel))});
  }
  if (const auto row = x.intrinsics_row(index)) {
    const auto d = intrinsics_derivative(x, index, camera, x.readout, pixel,
                                         in_camera(camera, x.world_T_imu, at_point), at_point.w);
    for (int i = 0; i < d.blocks; ++i) z.clones.push_back({.row = *row + 6 * i, .d = d.block(i)});
  }
  return true;
}

Eigen::Matrix2d bilinear_noise(const Camera& known, const Ekf& filter, int number, int index) {
  const State& x = filter.state();
  const Landmark& landmark = x.landmarks[static_cast<std::size_t>(number)];
  if (!landmark.anchor) return Eigen::Matrix2d::Zero();
  const Camera camera = as_estimated(known, x, index);
  const auto seen = see(camera, x.world_T_imu, x.homogeneous(landmark), Vector2d::Zero());
  if (!seen) return Eigen::Matrix2d::Zero();
  const auto P = filter.covariance();
  const int w = landmark.row + 2, anchor = x.clone(*landmark.anchor).row + 3;
  const Matrix3d now_anchor = P.block<3, 3>(3, anchor);
  const Matrix3d of_way =
      P.block<3, 3>(3, 3) + P.block<3, 3>(anchor, anchor) - now_anchor - now_anchor.transpose();
  const Vector3d with_w = P.block<3, 1>(3, w) - P.block<3, 1>(anchor, w);
  return seen->d_point * (P(w, w) * of_way + with_w * with_w.transpose()) *
         seen->d_point.transpose();
}

Matrix3d drift_noise(const Camera& known, const State& x, const Landmark& landmark, double variance,
                     int index) {
  if (landmark.anchor && landmark.face != AnchorFace::kFront) {
    if (const auto noise = noise_beside(known, landmark, variance)) return *noise;
  }
  const Vector2d f = focal_lengths_at_axis(known);
  const double u = variance / (f.x() * f.x()), v = variance / (f.y() * f.y());
  if (landmark.anchor) return Vector3d(u, v, 0).asDiagonal();
  const SE3 world_T_cam = x.world_T_imu * as_estimated(known, x, index).cam_T_imu.inverse();
  const Vector3d ray = landmark.p_world - world_T_cam.p;
  const Matrix3d across = ray.squaredNorm() * Matrix3d::Identity() - ray * ray.transpose();
  return (u + v) / 2 * across;
}

std::optional<NewLandmark> initialise_at_depth(const Camera& known, double sigma, const State& x,
                                               LandmarkId id, const Vector2d& pixel, double depth,
                                               double depth_sigma, int index) {
  const Camera camera = as_estimated(known, x, index, pixel);
  const auto ray = wide_ray(camera, pixel);
  if (!ray) return std::nullopt;
  const Matrix3d world_R_cam = x.world_T_imu.R * camera.cam_T_imu.R.transpose();
  NewLandmark result;
  result.id = id;
  result.p_world = x.world_T_imu * (camera.cam_T_imu.inverse() * (depth * ray->ray));
  result.d_pose << -hat(result.p_world - x.world_T_imu.p), Matrix3d::Identity();
  const Eigen::Matrix<double, 3, 2> d_pixel = depth * world_R_cam * ray->d_pixel;
  const Vector3d d_depth = world_R_cam * ray->ray;
  result.noise = sigma * sigma * d_pixel * d_pixel.transpose() +
                 depth_sigma * depth_sigma * d_depth * d_depth.transpose();
  if (const auto row = x.camera_row(index)) {
    Eigen::Matrix<double, 3, 6> d;
    d << -hat(camera.cam_T_imu.R.transpose() * (depth * ray->ray)), Matrix3d::Identity();
    d = (x.world_T_imu.R * d).eval();
    result.clones.push_back(
        {.row = *row, .d = by_axes_of_line(d, imu_T_line(camera, x.readout, pixel))});
  }
  if (const auto row = x.intrinsics_row(index)) {
    const auto by = intrinsics_derivative(x, index, camera, x.readout, pixel, depth * ray->ray, 1);
    for (int i = 0; i < by.blocks; ++i) {
      Eigen::Matrix<double, 3, 6> d = -d_pixel * by.block(i);
      if (i == 0) d.col(Intrinsics::kReadoutRow) = -world_R_cam * by.p_cam_by_readout;
      result.clones.push_back({.row = *row + 6 * i, .d = d});
    }
  }
  return result;
}

std::optional<NewLandmark> initialise_anchored(const Camera& known, double sigma, const State& x,
                                               LandmarkId id, const Vector2d& pixel,
                                               double inverse_depth, double inverse_depth_sigma,
                                               int index) {
  const Camera camera = as_estimated(known, x, index, pixel);
  const auto ray = face_ray(camera, pixel);
  if (!ray) return std::nullopt;
  NewLandmark result;
  result.id = id;
  result.anchor = x.clones.back().id;
  result.camera = index;
  result.face = ray->face;
  result.cam_T_imu = face_T_imu(ray->face, camera.cam_T_imu);
  result.imu_T_line = imu_T_line(camera, x.readout, pixel);
  result.inverse_depth << ray->xy, inverse_depth;
  result.noise.topLeftCorner<2, 2>() = sigma * sigma * ray->d_pixel * ray->d_pixel.transpose();
  result.noise(2, 2) = inverse_depth_sigma * inverse_depth_sigma;
  // The axes of the anchor stay where its line is by the present readout.
  if (const auto row = x.intrinsics_row(index)) {
    const Matrix3d to_face = face_R_cam(ray->face);
    const Vector3d along = to_face.transpose() * Vector3d(ray->xy.x(), ray->xy.y(), 1);
    const auto by = intrinsics_derivative(x, index, camera, x.readout, pixel, along, inverse_depth);
    for (int i = 0; i < by.blocks; ++i) {
      Eigen::Matrix<double, 3, 6> d = Eigen::Matrix<double, 3, 6>::Zero();
      d.topRows<2>() = -ray->d_pixel * by.block(i);
      if (i == 0) {
        const Vector3d moved = to_face * by.p_cam_by_readout;
        d.col(Intrinsics::kReadoutRow) = moved.z() * result.inverse_depth;
        d.col(Intrinsics::kReadoutRow).head<2>() -= moved.head<2>();
      }
      result.clones.push_back({.row = *row + 6 * i, .d = d});
    }
  }
  return result;
}

}  // namespace chasles
