#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory_resource>
#include <vector>

#include <Eigen/Cholesky>

#include <chasles/camera/anchor_face.hpp>
#include <chasles/camera/distortion.hpp>
#include <chasles/camera/stereo.hpp>
#include <chasles/camera/triangulation.hpp>
#include <chasles/lie/small_matrices.hpp>

namespace chasles {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr int kMaxSteps = 100;
constexpr double kPixelRoundOff = 1e-11;  // norm of all residuals [px]
constexpr double kConvergedStep =
    1e-9;  // step [px]: square root of the predicted decrease of the cost
constexpr double kMaxDamping = 1e12;      // the step is too short to improve the start
constexpr double kSingular = 1e-13;       // share of the inverse depth in the information
constexpr double kInfinitelyFar = 1e-12;  // parallax of the baseline [rad]

// A view relative to the anchor. Lengths are in units of the baseline.
struct Ray {
  const Camera* camera = nullptr;
  bool sees_beside = false;  // the camera
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Vector3d centre_world = Eigen::Vector3d::Zero();  // of the camera [m]
  Eigen::Matrix3d cam_R_world = Eigen::Matrix3d::Identity();
  Eigen::Vector3d ray_world = Eigen::Vector3d::Zero();  // of the pixel, unit length
  Eigen::Matrix3d cam_R_anchor = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p_cam_anchor = Eigen::Vector3d::Zero();  // the anchor's centre in this camera
};

struct Rays {
  std::pmr::vector<Ray> views;
  std::size_t anchor = 0;
  Eigen::Matrix3d anchor_R_world = Eigen::Matrix3d::Identity();  // axes of the anchor ray's face
  double baseline = 0;  // from the anchor to the view farthest from it [m]
};

// (alpha, beta, rho): the point is baseline / rho (alpha, beta, 1) from the anchor's camera, in the
// axes of its ray's face (camera/anchor_face.hpp). Its
// direction in a view, R (alpha, beta, 1) + rho t, is smooth through rho = 0, the points at
// infinity.
using InverseDepthPoint = Eigen::Vector3d;

// The normal equations of the reprojection errors at a point.
struct Normal {
  double cost = 0;                                     // sum of squares [px^2]
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();    // J^T J
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  // J^T (measured - projected)
};

// Up to this number of views, no heap memory is allocated.
constexpr std::size_t kUsualViews = 64;
using Room = std::array<std::byte, kUsualViews*(sizeof(Ray) + sizeof(Eigen::Vector3d))>;

std::optional<Rays> rays_of(std::span<const View> views, std::pmr::memory_resource* memory) {
  Rays rays{.views = std::pmr::vector<Ray>(memory)};
  rays.views.reserve(views.size());
  for (const View& view : views) {
    if (view.camera == nullptr) return std::nullopt;
    const std::optional<WideRay> pixel_ray = wide_ray(*view.camera, view.pixel);
    if (!pixel_ray) return std::nullopt;
    const SE3 world_T_cam = view.world_T_imu * view.camera->cam_T_imu.inverse();
    if (!world_T_cam.R.allFinite() || !world_T_cam.p.allFinite()) return std::nullopt;
    Ray ray;
    ray.camera = view.camera;
    ray.sees_beside = sees_beside(*view.camera);
    ray.pixel = view.pixel;
    ray.centre_world = world_T_cam.p;
    ray.cam_R_world = world_T_cam.R.transpose();
    ray.ray_world = world_T_cam.R * pixel_ray->ray / pixel_ray->ray.norm();
    rays.views.push_back(ray);
  }
  return rays;
}

// Chooses the anchor; false if all views have the same position, to round-off.
bool set_anchor(Rays& rays) {
  std::pmr::vector<Ray>& views = rays.views;
  // The mean is relative to the first view: no loss of precision far from the world's origin.
  const Eigen::Vector3d first = views[0].centre_world;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Ray& view : views) middle += view.centre_world - first;
  middle = first + middle / static_cast<double>(views.size());
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double distance = (views[i].centre_world - middle).squaredNorm();
    if (distance < nearest) rays.anchor = i;
    nearest = std::min(nearest, distance);
  }
  const Ray anchor = views[rays.anchor];
  const Eigen::Vector3d ray = anchor.cam_R_world * anchor.ray_world;
  rays.anchor_R_world = face_R_cam(face_towards(ray)) * anchor.cam_R_world;
  double round_off = 0;
  for (Ray& view : views) {
    view.cam_R_anchor = view.cam_R_world * rays.anchor_R_world.transpose();
    view.p_cam_anchor = view.cam_R_world * (anchor.centre_world - view.centre_world);
    rays.baseline = std::max(rays.baseline, view.p_cam_anchor.norm());
    round_off = std::max(
        round_off, 16 * kEpsilon * (view.centre_world.norm() + view.camera->cam_T_imu.p.norm()));
  }
  if (!(rays.baseline > round_off)) return false;
  for (Ray& view : views) view.p_cam_anchor /= rays.baseline;
  return true;
}

// Where a camera has a direction, from the principal point [px], and the derivative by the point of
// which d_point is the direction's derivative. None outside the lens model.
struct Image {
  Eigen::Vector2d from_centre;
  Eigen::Matrix<double, 2, 3> d_point;
};

std::optional<Image> image_beside(const Camera& camera, const Eigen::Vector3d& seen,
                                  const Eigen::Matrix3d& d_point) {
  const double length = seen.norm();
  const std::optional<PixelProjection> projection = project(camera, seen / length);
  if (!projection) return std::nullopt;
  return Image{.from_centre = projection->pixel - Eigen::Vector2d(camera.cx, camera.cy),
               .d_point = projection->d_point / length * d_point};
}

std::optional<Image> image_of(const Ray& view, const Eigen::Vector3d& seen,
                              const Eigen::Matrix3d& d_point) {
  const Camera& camera = *view.camera;
  if (!seen.allFinite()) return std::nullopt;
  if (view.sees_beside && !is_ahead(seen)) return image_beside(camera, seen, d_point);
  if (!(seen.z() > 0)) return std::nullopt;
  const Eigen::Vector2d xy = seen.head<2>() / seen.z();
  const std::optional<DistortedPoint> bent = distort(camera, xy);
  if (!bent) return std::nullopt;
  const Eigen::Vector2d focal(camera.fx, camera.fy);
  const Eigen::Matrix2d d_xy = focal.asDiagonal() * bent->d_xy / seen.z();
  return Image{.from_centre = focal.cwiseProduct(bent->xy),
               .d_point = d_xy * (d_point.topRows<2>() - xy * d_point.row(2))};
}

// None if a camera does not see the point.
std::optional<Normal> normal_equations(const Rays& rays, const InverseDepthPoint& point) {
  Normal normal;
  for (const Ray& view : rays.views) {
    Eigen::Matrix3d d_point = view.cam_R_anchor;
    d_point.col(2) = view.p_cam_anchor;
    const Eigen::Vector3d seen = d_point * point + view.cam_R_anchor.col(2);
    const std::optional<Image> image = image_of(view, seen, d_point);
    if (!image) return std::nullopt;
    const Eigen::Vector2d principal(view.camera->cx, view.camera->cy);
    const Eigen::Vector2d residual = view.pixel - principal - image->from_centre;
    const Eigen::Matrix<double, 2, 3>& J = image->d_point;
    normal.cost += residual.squaredNorm();
    normal.matrix += J.transpose() * J;
    normal.gradient += J.transpose() * residual;
  }
  if (!std::isfinite(normal.cost)) return std::nullopt;
  return normal;
}

// The point nearest to all rays.
InverseDepthPoint linear_point(const Rays& rays) {
  const Ray& anchor = rays.views[rays.anchor];
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const Ray& view : rays.views) {
    const Eigen::Matrix3d across =
        Eigen::Matrix3d::Identity() - view.ray_world * view.ray_world.transpose();
    A += across;
    b += across * (view.centre_world - anchor.centre_world);
  }
  const Eigen::Vector3d p_anchor = rays.anchor_R_world * solve_symmetric(A, b);
  return {p_anchor.x() / p_anchor.z(), p_anchor.y() / p_anchor.z(), rays.baseline / p_anchor.z()};
}

// The best of the linear point and of some points on the anchor's ray. With little parallax, noise
// may move the linear point behind the cameras.
std::optional<InverseDepthPoint> start(const Rays& rays) {
  const Ray& anchor = rays.views[rays.anchor];
  const Eigen::Vector3d ray = rays.anchor_R_world * anchor.ray_world;
  const double x = ray.x() / ray.z();
  const double y = ray.y() / ray.z();
  std::optional<InverseDepthPoint> best;
  double least = std::numeric_limits<double>::infinity();
  for (const InverseDepthPoint& point :
       {linear_point(rays), {x, y, 1e-3}, {x, y, 0.03}, {x, y, 0.3}, {x, y, 1.5}}) {
    const std::optional<Normal> normal = normal_equations(rays, point);
    if (!normal || !(normal->cost < least)) continue;
    least = normal->cost;
    best = point;
  }
  return best;
}

struct Minimum {
  InverseDepthPoint point;
  Normal normal;
};

// Gauss-Newton; damped only while a full step does not reduce the cost.
std::optional<Minimum> minimise(const Rays& rays, const InverseDepthPoint& from) {
  Minimum at{.point = from, .normal = *normal_equations(rays, from)};
  double damping = 0;
  for (int i = 0; i < kMaxSteps && damping < kMaxDamping; ++i) {
    Eigen::Matrix3d damped = at.normal.matrix;
    damped.diagonal() *= 1 + damping;
    const Eigen::Vector3d step = solve_symmetric(damped, at.normal.gradient);
    const bool converged =
        damping == 0 && step.dot(at.normal.gradient) < kConvergedStep * kConvergedStep;
    const InverseDepthPoint point = at.point + step;
    const std::optional<Normal> normal = normal_equations(rays, point);
    // Round-off of the cost must not reject the last steps. It comes from the round-off of the
    // residuals, which is that of pixel coordinates, however small the residuals are.
    const double bound = std::pow(std::sqrt(at.normal.cost) * (1 + 1e-12) + kPixelRoundOff, 2);
    if (normal && normal->cost <= bound) {
      at = {.point = point, .normal = *normal};
      damping = damping > 1e-3 ? damping / 10 : 0;
      if (converged) return at;
    } else {
      damping = std::max(1e-3, 10 * damping);
    }
  }
  return std::nullopt;
}

double largest_parallax(const Rays& rays, const Eigen::Vector3d& p_world) {
  std::pmr::vector<Eigen::Vector3d> directions(rays.views.get_allocator());
  directions.reserve(rays.views.size());
  double chord2 = 0;
  for (const Ray& view : rays.views) {
    const Eigen::Vector3d direction = (p_world - view.centre_world).normalized();
    for (const Eigen::Vector3d& other : directions) {
      chord2 = std::max(chord2, (direction - other).squaredNorm());
    }
    directions.push_back(direction);
  }
  return 2 * std::asin(std::min(1.0, std::sqrt(chord2) / 2));
}

// As project.
bool far_enough(const Rays& rays, const Eigen::Vector3d& p_world) {
  return std::ranges::all_of(rays.views, [&](const Ray& view) {
    const Eigen::Vector3d ray = p_world - view.centre_world;
    if (view.cam_R_world.row(2).dot(ray) > kMinDepth) return true;
    return view.sees_beside && ray.norm() > kMinDepth;
  });
}

}  // namespace

std::optional<MultiViewPoint> triangulate(std::span<const View> views) {
  if (views.size() < 2) return std::nullopt;
  alignas(std::max_align_t) Room room;
  std::pmr::monotonic_buffer_resource memory(room.data(), room.size());
  std::optional<Rays> rays = rays_of(views, &memory);
  if (!rays || !set_anchor(*rays)) return std::nullopt;
  const std::optional<InverseDepthPoint> from = start(*rays);
  if (!from) return std::nullopt;
  const std::optional<Minimum> minimum = minimise(*rays, *from);
  if (!minimum || !(minimum->point.z() > kInfinitelyFar)) return std::nullopt;

  const auto& [point, normal] = *minimum;
  const Eigen::LLT<Eigen::Matrix3d> cholesky(normal.matrix);
  if (cholesky.info() != Eigen::Success) return std::nullopt;
  const Eigen::Matrix3d inverse = cholesky.solve(Eigen::Matrix3d::Identity());
  if (!(1 / inverse(2, 2) > kSingular * normal.matrix.trace())) return std::nullopt;

  const Ray& anchor = rays->views[rays->anchor];
  const double scale = rays->baseline / point.z();
  const Eigen::Vector3d p_anchor(scale * point.x(), scale * point.y(), scale);
  Eigen::Matrix3d d_point = scale * Eigen::Matrix3d::Identity();
  d_point.col(2) = -p_anchor / point.z();
  d_point = rays->anchor_R_world.transpose() * d_point;

  MultiViewPoint result;
  result.p_world = anchor.centre_world + rays->anchor_R_world.transpose() * p_anchor;
  if (!far_enough(*rays, result.p_world)) return std::nullopt;
  result.covariance = d_point * inverse * d_point.transpose();
  result.rms = std::sqrt(normal.cost / static_cast<double>(2 * views.size()));
  result.parallax = largest_parallax(*rays, result.p_world);
  return result;
}

}  // namespace chasles
