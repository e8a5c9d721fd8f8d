#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/numeric/random.hpp>
#include <chasles/sim/inertial_world.hpp>
#include <chasles/sim/walk_path.hpp>

namespace chasles {
namespace {

constexpr double kMostLandmarks = 1e6;

// Whether the line segment from + t * ray, t in [0, end), intersects the box.
bool hits(const Box& box, const Eigen::Vector3d& from, const Eigen::Vector3d& ray, double end) {
  double enter = 0, leave = end;
  for (int axis = 0; axis < 3; ++axis) {
    if (ray[axis] == 0) {
      if (from[axis] <= box.low[axis] || from[axis] >= box.high[axis]) return false;
      continue;
    }
    const double a = (box.low[axis] - from[axis]) / ray[axis];
    const double b = (box.high[axis] - from[axis]) / ray[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter < leave;
}

// A rectangle: a corner and the two edges from it.
struct Face {
  Eigen::Vector3d corner, a, b;
  double area() const { return a.norm() * b.norm(); }
};

// The faces of a box: two along each axis; the last two are floor and ceiling.
std::array<Face, 6> faces(const Box& box) {
  std::array<Face, 6> result;
  const Eigen::Vector3d size = box.high - box.low;
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = a, across = a;
    a[(axis + 1) % 3] = size[(axis + 1) % 3];
    b[(axis + 2) % 3] = size[(axis + 2) % 3];
    across[axis] = size[axis];
    result[2 * static_cast<std::size_t>(axis)] = {box.low, a, b};
    result[2 * static_cast<std::size_t>(axis) + 1] = {box.low + across, a, b};
  }
  return result;
}

// The i-th of the points scattered evenly over the faces. Any sequence of consecutive points is
// scattered evenly, so that an order by number favours no place.
Eigen::Vector3d scattered(const std::vector<Face>& surface, double area, const Random& random,
                          std::uint64_t i) {
  double where = area * random.uniform(Stream::kLandmark, i, 0);
  std::size_t face = 0;
  while (face + 1 < surface.size() && where > surface[face].area()) {
    where -= surface[face].area();
    ++face;
  }
  return surface[face].corner + random.uniform(Stream::kLandmark, i, 1) * surface[face].a +
         random.uniform(Stream::kLandmark, i, 2) * surface[face].b;
}

double area_of(const std::vector<Face>& surface) {
  double area = 0;
  for (const Face& face : surface) area += face.area();
  return area;
}

// The number of landmarks on an area [m^2].
std::uint64_t landmark_count(const InertialSettings& settings, double area) {
  const double count = std::ceil(settings.wall_density * area);
  if (count > kMostLandmarks) {
    throw UsageError(fmt::format(
        "simulation setting wall_density = {} 1/m^2: {:.3g} landmarks; expected at most {:.0g}",
        settings.wall_density, count, kMostLandmarks));
  }
  return static_cast<std::uint64_t>(count);
}

// A ring has no simple faces: points on the floor or the ceiling below or above the block are
// removed.
InertialWorld hallway_world(const InertialSettings& settings) {
  const Hallway hall = make_hallway(settings);
  std::vector<Face> surface;
  for (const Face& face : faces(hall.outer)) surface.push_back(face);
  for (std::size_t i = 0; i < 4; ++i) surface.push_back(faces(hall.inner)[i]);
  const double area = area_of(surface);
  InertialWorld world{.points = {}, .walls = {hall.inner}};
  const std::uint64_t count = landmark_count(settings, area);
  for (std::uint64_t i = 0; i < count; ++i) {
    const Eigen::Vector3d p = scattered(surface, area, Random{settings.seed}, i);
    const Eigen::Array2d xy = p.head<2>();
    const bool hidden = (xy > hall.inner.low.head<2>().array()).all() &&
                        (xy < hall.inner.high.head<2>().array()).all();
    if (!hidden) world.points.push_back(p);
  }
  return world;
}

// Points on walls, floors and ceilings, without those inside the furniture, which occludes them.
InertialWorld walk_world(const InertialSettings& settings) {
  const FloorPlan plan = walk_plan(settings);
  const double floor = -settings.imu_height, height = settings.corridor_height;
  const Eigen::Vector3d up(0, 0, height);
  std::vector<Face> surface;
  for (const WallSegment& wall : plan_walls(plan)) {
    const Eigen::Vector2d along = wall.b - wall.a;
    surface.push_back({{wall.a.x(), wall.a.y(), floor}, {along.x(), along.y(), 0}, up});
  }
  for (const PlanRectangle& tile : plan_floors(plan)) {
    const Eigen::Vector2d size = tile.high - tile.low;
    for (const double z : {floor, floor + height}) {
      surface.push_back({{tile.low.x(), tile.low.y(), z}, {size.x(), 0, 0}, {0, size.y(), 0}});
    }
  }
  InertialWorld world{.points = {}, .walls = walk_furniture(settings)};
  for (const PlanRectangle& s : plan_solids(plan)) {
    world.walls.push_back(
        {{s.low.x(), s.low.y(), floor}, {s.high.x(), s.high.y(), floor + height}});
  }
  const double area = area_of(surface);
  const std::uint64_t count = landmark_count(settings, area);
  for (std::uint64_t i = 0; i < count; ++i) {
    world.points.push_back(scattered(surface, area, Random{settings.seed}, i));
  }
  return world;
}

InertialWorld turntable_world(const InertialSettings& settings) {
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(settings.cube_edge / 2);
  const Box cube{-half, half};
  const auto all = faces(cube);
  const std::vector<Face> surface(all.begin(), all.end());
  InertialWorld world{.points = {}, .walls = {cube}};
  for (int i = 0; i < settings.cube_landmarks; ++i) {
    world.points.push_back(
        scattered(surface, area_of(surface), Random{settings.seed}, static_cast<std::uint64_t>(i)));
  }
  return world;
}

// The i-th landmark placed in view of the camera; nothing if the lens has no ray for the pixel.
std::optional<Eigen::Vector3d> placed(const InertialSettings& settings, const Camera& camera,
                                      const SE3& world_T_imu, std::uint64_t i) {
  const Random random{settings.seed};
  const double border = settings.image_border;
  const auto within = [&](double size, std::uint32_t component) {
    return border + (size - 2 * border) * random.uniform(Stream::kLandmark, i, component);
  };
  const auto ray = wide_ray(camera, {within(camera.width, 0), within(camera.height, 1)});
  if (!ray) return std::nullopt;
  const double depth =
      settings.landmark_nearest + (settings.landmark_farthest - settings.landmark_nearest) *
                                      random.uniform(Stream::kLandmark, i, 2);
  return world_T_imu * (camera.cam_T_imu.inverse() * (depth * ray->ray));
}

InertialWorld trajectory_world(const InertialSettings& settings, const Spline& motion,
                               const Camera& camera) {
  InertialWorld world;
  std::uint64_t tries = 0;
  for (double time = 0; time <= motion.duration; time += settings.landmark_spacing) {
    const SE3 pose = motion_at(motion, time).world_T_imu;
    const auto seen = std::ranges::count_if(world.points, [&](const Eigen::Vector3d& p) {
      return visible_pixel(settings, world, camera, pose, p).has_value();
    });
    for (auto missing = settings.visible_landmarks - seen; missing > 0; --missing) {
      if (const auto p = placed(settings, camera, pose, tries++)) world.points.push_back(*p);
    }
    if (static_cast<double>(world.points.size()) > kMostLandmarks) {
      throw UsageError(fmt::format(
          "simulation setting visible_landmarks = {}: more than {:.0g} landmarks along the "
          "trajectory; expected fewer, or a larger landmark_spacing",
          settings.visible_landmarks, kMostLandmarks));
    }
  }
  return world;
}

}  // namespace

bool blocked(const std::vector<Box>& walls, const Eigen::Vector3d& from,
             const Eigen::Vector3d& to) {
  constexpr double kBefore = 1 - 1e-6;
  const Eigen::Vector3d ray = to - from;
  return std::ranges::any_of(walls,
                             [&](const Box& wall) { return hits(wall, from, ray, kBefore); });
}

namespace {

// The place of a camera in its rig: turned about the IMU's z axis, and so many baselines aside.
struct RigPlace {
  double yaw = 0;  // [rad]
  int aside = 0;
};

RigPlace place_of(const InertialSettings& settings, int camera) {
  switch (settings.rig) {
    case RigLayout::kSideBySide:
      return {.aside = camera};
    case RigLayout::kBackToBack:
      return {.yaw = M_PI * (camera % 2), .aside = camera / 2};
    case RigLayout::kRing:
      return {.yaw = 2 * M_PI * camera / settings.cameras};
  }
  return {};
}

}  // namespace

std::vector<Camera> make_cameras(const InertialSettings& settings) {
  Eigen::Matrix3d imu_R_straight;  // its columns: the camera's right, down and forward
  imu_R_straight << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Eigen::Matrix3d tilt =
      so3::exp({settings.camera_tilt_x, settings.camera_tilt_y, settings.camera_tilt_z});
  std::vector<Camera> cameras;
  for (int i = 0; i < settings.cameras; ++i) {
    const RigPlace place = place_of(settings, i);
    const Eigen::Vector3d aside(0, -place.aside * settings.baseline, 0);
    const Eigen::Vector3d first(settings.camera_x, settings.camera_y, settings.camera_z);
    SE3 imu_T_cam{tilt * imu_R_straight, first + tilt * aside};
    if (place.yaw != 0) imu_T_cam = SE3{so3::exp({0, 0, place.yaw}), {0, 0, 0}} * imu_T_cam;
    cameras.push_back(
        {.width = settings.image_width,
         .height = settings.image_height,
         .fx = settings.focal_length,
         .fy = settings.focal_length,
         .cx = settings.center_u,
         .cy = settings.center_v,
         .distortion = settings.distortion,
         .coefficients = lens_coefficients(settings),
         .cam_T_imu = imu_T_cam.inverse(),
         .shutter = {.readout = settings.readout_time, .direction = settings.readout_direction}});
  }
  return cameras;
}

std::optional<Eigen::Vector2d> visible_pixel(const InertialSettings& settings,
                                             const InertialWorld& world, const Camera& camera,
                                             const SE3& world_T_imu,
                                             const Eigen::Vector3d& p_world) {
  const Eigen::Vector3d p_cam = camera.cam_T_imu * (world_T_imu.inverse() * p_world);
  const double range = p_cam.norm();
  if (range < settings.min_range || range > settings.max_range) return std::nullopt;
  const auto projection = project(camera, p_cam);
  if (!projection || !in_image(camera, projection->pixel, settings.image_border)) {
    return std::nullopt;
  }
  if (settings.occlusion) {
    const Eigen::Vector3d eye = world_T_imu * camera.cam_T_imu.inverse().p;
    if (blocked(world.walls, eye, p_world)) return std::nullopt;
  }
  return projection->pixel;
}

InertialWorld make_world(const InertialSettings& settings, const Spline& motion,
                         const std::vector<Camera>& cameras) {
  if (settings.geometry == Geometry::kHallway) return hallway_world(settings);
  if (settings.geometry == Geometry::kTurntable) return turntable_world(settings);
  if (settings.geometry == Geometry::kWalk) return walk_world(settings);
  return trajectory_world(settings, motion, cameras.front());
}

}  // namespace chasles
