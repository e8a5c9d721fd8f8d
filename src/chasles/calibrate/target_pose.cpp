#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <chasles/calibrate/levenberg_marquardt.hpp>
#include <chasles/calibrate/target_pose.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kLeastOfPose = 4;

struct SeenCorner {
  Vector3d p_target;
  Vector3d bearing;
};

std::vector<SeenCorner> seen_corners(const Camera& camera, std::span<const Vector3d> corners,
                                     const TargetView& view) {
  std::vector<SeenCorner> seen;
  for (std::size_t i = 0; i < view.ids.size(); ++i) {
    if (const auto direction = bearing(camera, view.pixels[i])) {
      seen.push_back({corners[static_cast<std::size_t>(view.ids[i])], direction->bearing});
    }
  }
  return seen;
}

// [r1 r2 t] of the target's plane up to a factor: the bearing times H (x, y, 1) is zero.
std::optional<SE3> pose_from_homography(const std::vector<SeenCorner>& seen) {
  Vector2d centre = Vector2d::Zero();
  for (const SeenCorner& s : seen) centre += s.p_target.head<2>();
  centre /= static_cast<double>(seen.size());
  double size = 0;
  for (const SeenCorner& s : seen) size = std::max(size, (s.p_target.head<2>() - centre).norm());
  if (size == 0) return std::nullopt;
  Eigen::MatrixXd A(3 * static_cast<Eigen::Index>(seen.size()), 9);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const Matrix3d cross = hat(seen[i].bearing);
    Vector3d x;
    x << (seen[i].p_target.head<2>() - centre) / size, 1;
    for (int k = 0; k < 3; ++k) {
      A.block<3, 3>(3 * static_cast<Eigen::Index>(i), 3 * k) = cross * x[k];
    }
  }
  const Eigen::JacobiSVD<Eigen::Matrix<double, 9, 9>> svd(A.transpose() * A, Eigen::ComputeFullV);
  if (svd.singularValues()[7] <= 1e-12 * svd.singularValues()[0]) return std::nullopt;  // a line
  const Eigen::Matrix<double, 9, 1> h = svd.matrixV().col(8);
  Vector3d a = h.segment<3>(0), b = h.segment<3>(3), t = h.segment<3>(6);
  // The corners are along their bearings, not against them.
  double along = 0;
  for (const SeenCorner& s : seen) {
    const Vector2d x = (s.p_target.head<2>() - centre) / size;
    along += s.bearing.dot(a * x.x() + b * x.y() + t) > 0 ? 1 : -1;
  }
  const double scale = (along > 0 ? 2 : -2) / (a.norm() + b.norm());
  if (!std::isfinite(scale)) return std::nullopt;
  a *= scale, b *= scale, t *= scale;
  Matrix3d R;
  R << a, b, a.cross(b);
  SE3 pose;
  pose.R = so3::normalized(R);
  pose.p = size * t - pose.R * Vector3d(centre.x(), centre.y(), 0);
  return pose;
}

struct PoseStep {
  Vector6d d;
  double decrease = 0;
};

struct PoseEquations {
  Matrix6d H = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();
  double cost = 0, squares = 0;
  std::size_t corners = 0;

  std::optional<PoseStep> solve(double damping) const {
    Matrix6d damped = H;
    damped.diagonal() *= 1 + damping;
    const Vector6d d = -damped.ldlt().solve(g);
    if (!d.allFinite()) return std::nullopt;
    return PoseStep{d, (damping * d.dot(H.diagonal().cwiseProduct(d)) - g.dot(d)) / 2};
  }
};

std::optional<PoseEquations> equations(const Camera& camera, std::span<const Vector3d> corners,
                                       const TargetView& view, const SE3& pose, double width) {
  PoseEquations e;
  for (std::size_t i = 0; i < view.ids.size(); ++i) {
    const Vector3d arm = pose.R * corners[static_cast<std::size_t>(view.ids[i])];
    const auto image = project(camera, arm + pose.p);
    if (!image) return std::nullopt;
    const Vector2d r = image->pixel - view.pixels[i];
    const double size = r.norm(), weight = size <= width ? 1 : width / size;
    Eigen::Matrix<double, 2, 6> J;
    J << -image->d_point * hat(arm), image->d_point;
    e.H.noalias() += weight * J.transpose() * J;
    e.g.noalias() += weight * J.transpose() * r;
    e.cost += size <= width ? size * size / 2 : width * (size - width / 2);
    e.squares += size * size;
    ++e.corners;
  }
  return e;
}

SE3 moved_pose(const SE3& pose, const PoseStep& step) {
  return {so3::normalized(so3::exp(step.d.head<3>()) * pose.R), pose.p + step.d.tail<3>()};
}

}  // namespace

std::optional<TargetPose> refined_pose(const Camera& camera, std::span<const Vector3d> corners,
                                       const TargetView& view, const SE3& cam_T_target,
                                       double loss_width) {
  if (view.ids.size() < kLeastOfPose) return std::nullopt;
  const auto found = minimised(
      cam_T_target,
      [&](const SE3& pose) { return equations(camera, corners, view, pose, loss_width); },
      moved_pose);
  if (!found) return std::nullopt;
  const SE3& pose = found->state;
  // From behind a board cannot be read.
  if ((pose.R.transpose() * pose.p).z() > 0) return std::nullopt;
  const PoseEquations& at = found->linearised;
  return TargetPose{pose, std::sqrt(at.squares / static_cast<double>(at.corners))};
}

std::optional<TargetPose> target_pose(const Camera& camera, std::span<const Vector3d> corners,
                                      const TargetView& view, double loss_width) {
  const std::vector<SeenCorner> seen = seen_corners(camera, corners, view);
  if (seen.size() < kLeastOfPose) return std::nullopt;
  const std::optional<SE3> start = pose_from_homography(seen);
  if (!start) return std::nullopt;
  return refined_pose(camera, corners, view, *start, loss_width);
}

bool is_seen_from_behind(std::span<const Eigen::Vector3d> corners, const TargetView& view) {
  Eigen::Matrix2d products = Eigen::Matrix2d::Zero();  // of places on the board and in the image
  Eigen::Vector2d places = Eigen::Vector2d::Zero(), pixels = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < view.ids.size(); ++i) {
    const Eigen::Vector2d place = corners[static_cast<std::size_t>(view.ids[i])].head<2>();
    products += place * view.pixels[i].transpose();
    places += place;
    pixels += view.pixels[i];
  }
  const double n = std::max(1.0, static_cast<double>(view.ids.size()));
  return (products - places * pixels.transpose() / n).determinant() > 0;
}

}  // namespace chasles
