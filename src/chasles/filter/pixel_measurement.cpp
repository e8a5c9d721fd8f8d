#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include <chasles/camera/triangulation.hpp>
#include <chasles/filter/calibration.hpp>
#include <chasles/filter/pixel_measurement.hpp>
#include <chasles/filter/pixel_sight.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Matrix23d = Eigen::Matrix<double, 2, 3>;

constexpr int kRowsOfAMeasurement = 6;

// The same by the errors of imu_T_camera: p_cam = R_ic^T (p_imu - p_ic).
Eigen::Matrix<double, 2, 6> derivative_by_camera(const Camera& camera, const SE3& world_T_imu,
                                                 const HomogeneousPoint& point,
                                                 const Matrix23d& d_point) {
  const Matrix23d d_imu = d_point * world_T_imu.R;
  const Vector3d p_imu = world_T_imu.R.transpose() * (point.p_world - point.w * world_T_imu.p);
  Eigen::Matrix<double, 2, 6> d;
  d << d_imu * hat(p_imu - point.w * camera.cam_T_imu.inverse().p), -point.w * d_imu;
  return d;
}

// Of the clones and cameras that the views depend on, each once.
std::vector<int> rows_of(const State& x, std::span<const ClonedView> views) {
  std::vector<int> rows;
  rows.reserve(views.size() + x.imu_T_camera.size());
  const auto note = [&](int row) {
    if (std::find(rows.begin(), rows.end(), row) == rows.end()) rows.push_back(row);
  };
  for (const ClonedView& view : views) note(x.clone(view.clone).row);
  for (const ClonedView& view : views) {
    if (const auto row = x.camera_row(view.camera)) note(*row);
  }
  return rows;
}

}  // namespace

std::optional<Measurement> measure_pixel(const Camera& known, double sigma, const State& x,
                                         int number, const Vector2d& pixel, Linearisation at,
                                         int index) {
  const Camera camera = as_estimated(known, x, index);
  const Landmark& landmark = x.landmarks[static_cast<std::size_t>(number)];
  const bool first = at == Linearisation::kFirstEstimates;
  const HomogeneousPoint point = x.homogeneous(landmark);
  const auto now = see(camera, x.world_T_imu, point, pixel);
  // An anchored landmark's own parameters may be anything at first: the poses alone are kept.
  State at_first;
  if (first && landmark.anchor) {
    at_first.clones = {x.clone(*landmark.anchor)};
    at_first.clones.front().world_T_imu = at_first.clones.front().first;
  }
  const HomogeneousPoint at_point = !first            ? point
                                    : landmark.anchor ? at_first.homogeneous(landmark)
                                                      : HomogeneousPoint{landmark.first};
  const auto seen = first ? see(camera, x.world_T_imu, at_point, pixel) : now;
  if (!now || !seen) return std::nullopt;
  Measurement z;
  z.landmark = number;
  z.residual = now->residual;
  z.d_core = seen->d_pose;
  z.d_landmark = seen->d_point;
  z.noise = sigma * sigma * Eigen::Matrix2d::Identity();
  if (landmark.anchor) {
    const Clone& clone = first ? at_first.clones.front() : x.clone(*landmark.anchor);
    const Eigen::Matrix<double, 3, 9> d = homogeneous_derivative(clone, landmark);
    z.clones.push_back({.row = clone.row, .d = seen->d_point * d.leftCols<6>()});
    z.d_landmark = seen->d_point * d.rightCols<3>();
    z.d_landmark.rightCols<1>() += seen->d_w;
    if (const auto row = x.camera_row(landmark.camera)) {
      z.clones.push_back(
          {.row = *row, .d = seen->d_point * homogeneous_derivative_by_camera(clone, landmark)});
    }
  }
  if (const auto row = x.camera_row(index)) {
    z.clones.push_back(
        {.row = *row, .d = derivative_by_camera(camera, x.world_T_imu, at_point, seen->d_point)});
  }
  return z;
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

std::optional<NewLandmark> begin_at_depth(const Camera& known, double sigma, const State& x,
                                          LandmarkId id, const Vector2d& pixel, double depth,
                                          double depth_sigma, int index) {
  const Camera camera = as_estimated(known, x, index);
  const auto ray = unproject(camera, pixel);
  if (!ray) return std::nullopt;
  const Matrix3d world_R_cam = x.world_T_imu.R * camera.cam_T_imu.R.transpose();
  NewLandmark result;
  result.id = id;
  result.p_world = x.world_T_imu * (camera.cam_T_imu.inverse() * (depth * ray->ray));
  result.d_pose << -hat(result.p_world - x.world_T_imu.p), Matrix3d::Identity();
  const Eigen::Matrix<double, 3, 2> d_pixel = depth * world_R_cam.leftCols<2>() * ray->d_pixel;
  const Vector3d d_depth = world_R_cam * ray->ray;
  result.noise = sigma * sigma * d_pixel * d_pixel.transpose() +
                 depth_sigma * depth_sigma * d_depth * d_depth.transpose();
  if (const auto row = x.camera_row(index)) {
    Eigen::Matrix<double, 3, 6> d;
    d << -hat(camera.cam_T_imu.R.transpose() * (depth * ray->ray)), Matrix3d::Identity();
    result.clones.push_back({.row = *row, .d = x.world_T_imu.R * d});
  }
  return result;
}

std::optional<NewLandmark> begin_anchored(const Camera& camera, double sigma, const State& x,
                                          LandmarkId id, const Vector2d& pixel,
                                          double inverse_depth, double inverse_depth_sigma,
                                          int index) {
  const auto ray = unproject(camera, pixel);
  if (!ray) return std::nullopt;
  NewLandmark result;
  result.id = id;
  result.anchor = x.clones.back().id;
  result.camera = index;
  result.cam_T_imu = as_estimated(camera, x, index).cam_T_imu;
  result.inverse_depth << ray->ray.head<2>(), inverse_depth;
  result.noise.topLeftCorner<2, 2>() = sigma * sigma * ray->d_pixel * ray->d_pixel.transpose();
  result.noise(2, 2) = inverse_depth_sigma * inverse_depth_sigma;
  return result;
}

std::optional<MultiViewStart> begin_multi_view(std::span<const Camera> cameras, double sigma,
                                               const State& x, LandmarkId id,
                                               std::span<const ClonedView> views, bool anchored,
                                               Linearisation at) {
  std::vector<Camera> estimated;
  if (!x.imu_T_camera.empty()) {
    estimated.reserve(cameras.size());
    for (const Camera& camera : cameras) {
      estimated.push_back(as_estimated(camera, x, static_cast<int>(estimated.size())));
    }
    cameras = estimated;
  }
  std::vector<View> from;
  from.reserve(views.size());
  for (const ClonedView& view : views) {
    from.push_back({.world_T_imu = x.clone(view.clone).world_T_imu,
                    .camera = &cameras[static_cast<std::size_t>(view.camera)],
                    .pixel = view.pixel});
  }
  const auto point = triangulate(from);
  if (!point) return std::nullopt;
  const HomogeneousPoint at_point{point->p_world};

  // r = H_x d_clones + H_f d_point + n
  const auto m = 2 * static_cast<Eigen::Index>(views.size());
  const std::vector<int> rows = rows_of(x, views);
  const auto column_of = [&](int row) {
    return 6 * (std::find(rows.begin(), rows.end(), row) - rows.begin());
  };
  MatrixXd H_f(m, 3);
  MatrixXd H_x = MatrixXd::Zero(m, 6 * static_cast<Eigen::Index>(rows.size()));
  VectorXd r(m);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Clone& clone = x.clone(views[i].clone);
    const auto now = see(*from[i].camera, from[i].world_T_imu, at_point, views[i].pixel);
    const auto seen = at == Linearisation::kCurrent
                          ? now
                          : see(*from[i].camera, clone.first, at_point, views[i].pixel);
    if (!now || !seen) return std::nullopt;
    const auto row = 2 * static_cast<Eigen::Index>(i);
    r.segment<2>(row) = now->residual;
    H_f.middleRows<2>(row) = seen->d_point;
    H_x.block<2, 6>(row, column_of(clone.row)) = seen->d_pose;
    if (const auto camera = x.camera_row(views[i].camera)) {
      const SE3& at_pose = at == Linearisation::kCurrent ? clone.world_T_imu : clone.first;
      H_x.block<2, 6>(row, column_of(*camera)) =
          derivative_by_camera(*from[i].camera, at_pose, at_point, seen->d_point);
    }
  }
  MultiViewStart result;
  const Vector3d from_imu = point->p_world - from.back().world_T_imu.p;
  const Vector3d along = from_imu.normalized();
  const MatrixXd d_point = -(H_f.transpose() * H_f).ldlt().solve(H_f.transpose() * H_x);
  result.distance = from_imu.norm();
  result.distance_noise = sigma * sigma * along.dot(point->covariance * along);
  result.d_distance.reserve(rows.size());
  for (std::size_t j = 0; j < rows.size(); ++j) {
    Eigen::Matrix<double, 1, 6> d =
        along.transpose() * d_point.middleCols<6>(6 * static_cast<Eigen::Index>(j));
    if (rows[j] == x.clone(views.back().clone).row) d.tail<3>() -= along.transpose();
    result.d_distance.push_back({.row = rows[j], .d = d});
  }
  result.landmark.id = id;
  result.landmark.p_world = point->p_world;
  if (anchored) {
    Clone anchor = x.clone(views.back().clone);
    const SE3& cam_T_imu = from.back().camera->cam_T_imu;
    const Vector3d p_cam = cam_T_imu * (anchor.world_T_imu.inverse() * point->p_world);
    result.landmark.anchor = anchor.id;
    result.landmark.camera = views.back().camera;
    result.landmark.cam_T_imu = cam_T_imu;
    result.landmark.inverse_depth = Vector3d(p_cam.x(), p_cam.y(), 1) / p_cam.z();
    Landmark landmark;
    landmark.cam_T_imu = cam_T_imu;
    landmark.inverse_depth = result.landmark.inverse_depth;
    if (at == Linearisation::kFirstEstimates) anchor.world_T_imu = anchor.first;
    const Eigen::Matrix<double, 3, 9> d = anchored_derivative(anchor, landmark);
    H_x.middleCols<6>(column_of(anchor.row)) += H_f * d.leftCols<6>();
    if (const auto camera = x.camera_row(views.back().camera)) {
      H_x.middleCols<6>(column_of(*camera)) +=
          H_f * anchored_derivative_by_camera(anchor, landmark);
    }
    H_f = (H_f * d.rightCols<3>()).eval();
  }
  const Eigen::HouseholderQR<MatrixXd> qr(H_f);
  const Matrix3d R = qr.matrixQR().topRows<3>().triangularView<Eigen::Upper>();
  H_x.applyOnTheLeft(qr.householderQ().transpose());
  r.applyOnTheLeft(qr.householderQ().transpose());

  // R d_point = r_1 - H_1 d_clones - n_1, and r_1 = 0 at the least-squares point.
  const Matrix3d R_inverse = R.triangularView<Eigen::Upper>().solve(Matrix3d::Identity());
  result.landmark.noise = sigma * sigma * R_inverse * R_inverse.transpose();
  result.landmark.observations = static_cast<int>(views.size());
  if (at == Linearisation::kFirstEstimates) {
    // At other values than the least-squares point's own r_1 is not zero.
    const Vector3d step = R_inverse * r.head<3>();
    (anchored ? result.landmark.inverse_depth : result.landmark.p_world) += step;
  }
  const MatrixXd d_clones = -R_inverse * H_x.topRows<3>();
  result.landmark.clones.reserve(rows.size());
  for (std::size_t j = 0; j < rows.size(); ++j) {
    const auto column = 6 * static_cast<Eigen::Index>(j);
    result.landmark.clones.push_back({.row = rows[j], .d = d_clones.middleCols<6>(column)});
  }
  result.rest.reserve((views.size() + 1) / 3);  // 2 v - 3 rows, 6 each
  for (Eigen::Index row = 3; row < m; row += kRowsOfAMeasurement) {
    const Eigen::Index k = std::min<Eigen::Index>(kRowsOfAMeasurement, m - row);
    Measurement z;
    z.residual = r.segment(row, k);
    z.d_core.resize(k, 0);
    z.clones.reserve(rows.size());
    z.noise = sigma * sigma * MatrixXd::Identity(k, k);
    for (std::size_t j = 0; j < rows.size(); ++j) {
      const auto column = 6 * static_cast<Eigen::Index>(j);
      z.clones.push_back({.row = rows[j], .d = H_x.block(row, column, k, 6)});
    }
    result.rest.push_back(std::move(z));
  }
  result.rest_rows = static_cast<int>(m - 3);
  result.parallax = point->parallax;
  return result;
}

double relative_depth_sigma(const MultiViewStart& start, const Ekf& filter) {
  const auto P = filter.covariance();
  double variance = start.distance_noise;
  for (const auto& a : start.d_distance) {
    for (const auto& b : start.d_distance) {
      variance += (a.d * P.block<6, 6>(a.row, b.row)).dot(b.d);
    }
  }
  return std::sqrt(std::max(variance, 0.0)) / start.distance;
}

}  // namespace chasles
