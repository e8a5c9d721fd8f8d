#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/sim/inertial_path.hpp>
#include <chasles/sim/inertial_path_detail.hpp>
#include <chasles/sim/smoothstep.hpp>

namespace chasles {
namespace {

constexpr double kPi = std::numbers::pi;
// Enough poses for the spline to follow the path.
constexpr double kPosesPerKnot = 8;
constexpr double kMostPoses = 1e7;

// The time on the path after a time of the clock. The path has constant speed; the start from a
// standstill stretches it.
double way_time(const InertialSettings& settings, double time) {
  const double since = time - settings.rest_duration;
  if (since <= 0) return 0;
  if (since >= settings.start_duration) return since - settings.start_duration / 2;
  return settings.start_duration * smoothstep_integral(since / settings.start_duration);
}

Eigen::Matrix3d from_angles(double yaw, double pitch, double roll) {
  using Eigen::Vector3d;
  return so3::exp(yaw * Vector3d::UnitZ()) * so3::exp(pitch * Vector3d::UnitY()) *
         so3::exp(roll * Vector3d::UnitX());
}

double straight_length(const InertialSettings& settings, int section) {
  const double side = section % 2 == 0 ? settings.hall_length : settings.hall_width;
  return side - 2 * turn_reach(settings);
}

// The position after a distance. Four sections are a lap, which leads back to the start.
Step walked(const InertialSettings& settings, double way) {
  const double turn = turn_length(settings), reach = turn_reach(settings);
  const double lap = 2 * (straight_length(settings, 0) + straight_length(settings, 1) + 2 * turn);
  way = std::fmod(way, lap);
  Step at{Eigen::Vector2d::Zero(), 0};
  for (int section = 0;; ++section) {
    const double straight = straight_length(settings, section);
    const Eigen::Rotation2Dd heading(at.heading);
    at.p += heading * Eigen::Vector2d(std::min(way, straight), 0);
    if (way <= straight) return at;
    way -= straight;
    if (way <= turn) {
      at.p += heading * (turn * quarter_turn(way / turn));
      at.heading -= kPi / 2 * smoothstep(way / turn);
      return at;
    }
    at.p += heading * Eigen::Vector2d(reach, -reach);
    at.heading -= kPi / 2;
    way -= turn;
  }
}

double walk_length(const InertialSettings& settings) {
  double length = settings.sections * turn_length(settings);
  for (int i = 0; i < settings.sections; ++i) length += straight_length(settings, i);
  return length;
}

SE3 walker(const InertialSettings& settings, double time) {
  return with_gait(settings, walked(settings, settings.walking_speed * time), time);
}

void check_clearance(const InertialSettings& settings, const Trajectory& path) {
  constexpr double kClearance = 0.1;
  const Hallway hall = make_hallway(settings);
  for (const auto& [time, pose] : path) {
    const Eigen::Array3d p = pose.p.array();
    const bool inside = (p > hall.outer.low.array() + kClearance).all() &&
                        (p < hall.outer.high.array() - kClearance).all();
    const bool in_block = (p.head<2>() > hall.inner.low.head<2>().array() - kClearance).all() &&
                          (p.head<2>() < hall.inner.high.head<2>().array() + kClearance).all();
    if (inside && !in_block) continue;
    throw UsageError(fmt::format(
        "simulation setting corridor_width = {} m: the walk comes nearer than {} m to a wall at "
        "{:.1f} s; expected a wider or higher corridor, less sway, or a shorter turn_duration",
        settings.corridor_width, kClearance, to_seconds(time)));
  }
}

}  // namespace

Trajectory sample_way(const InertialSettings& settings, double duration,
                      const std::function<SE3(double)>& pose) {
  const double total = duration + settings.rest_duration + settings.start_duration / 2;
  const double count = std::ceil(kPosesPerKnot * total / settings.knot_interval);
  if (count > kMostPoses) {
    throw UsageError(fmt::format(
        "simulation setting knot_interval = {} s: a motion of {:.0f} s has {:.3g} "
        "knots; expected at most {:.3g}",
        settings.knot_interval, total, count / kPosesPerKnot, kMostPoses / kPosesPerKnot));
  }
  Trajectory path;
  for (double i = 0; i <= count; ++i) {
    const double time = total * i / count;
    path.push_back({from_seconds(time), pose(way_time(settings, time))});
  }
  return path;
}

// The integral of the direction, by Simpson's rule.
Eigen::Vector2d quarter_turn(double x) {
  constexpr int kSteps = 32;
  const auto direction = [](double at) {
    const double angle = kPi / 2 * smoothstep(at);
    return Eigen::Vector2d(std::cos(angle), -std::sin(angle));
  };
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  const double h = x / kSteps;
  for (int i = 0; i < kSteps; ++i) {
    sum += direction(i * h) + 4 * direction((i + 0.5) * h) + direction((i + 1) * h);
  }
  return h / 6 * sum;
}

double turn_length(const InertialSettings& settings) {
  return settings.walking_speed * settings.turn_duration;
}

// It ends at the same distance after the corner.
double turn_reach(const InertialSettings& settings) {
  static const double reach = quarter_turn(1).x();
  return turn_length(settings) * reach;
}

// Sway and rotation at one rate about perpendicular axes are in quadrature, as for a walker. Their
// product then has zero mean, and sampling causes no drift (sculling).
SE3 with_gait(const InertialSettings& settings, const Step& step, double time) {
  const double every = 2 * kPi * settings.step_rate * time;
  const double second = every / 2;
  const Eigen::Rotation2Dd heading(step.heading);
  const Eigen::Vector2d p =
      step.p + heading * Eigen::Vector2d(0, settings.sway_amplitude * std::sin(second));
  return {from_angles(step.heading + settings.yaw_amplitude * std::cos(second),
                      settings.pitch_amplitude * std::cos(every),
                      settings.roll_amplitude * std::cos(second)),
          {p.x(), p.y(), settings.bob_amplitude * std::sin(every)}};
}

Hallway make_hallway(const InertialSettings& settings) {
  const double reach = turn_reach(settings);
  const double shortest = std::min(settings.hall_length, settings.hall_width);
  if (shortest < 2 * reach) {
    throw UsageError(fmt::format(
        "simulation setting turn_duration = {} s: two turns at {} m/s need {:.2f} m; expected at "
        "most the shorter side of the hallway, {} m",
        settings.turn_duration, settings.walking_speed, 2 * reach, shortest));
  }
  const double floor = -settings.imu_height;
  const double ceiling = settings.corridor_height - settings.imu_height;
  const Eigen::Vector3d half(settings.corridor_width / 2, settings.corridor_width / 2, 0);
  const Eigen::Vector3d low(-reach, -settings.hall_width, floor);
  const Eigen::Vector3d high(settings.hall_length - reach, 0, ceiling);
  return {.outer = {low - half, high + half}, .inner = {low + half, high - half}};
}

Trajectory hallway_path(const InertialSettings& settings) {
  make_hallway(settings);
  const double duration = walk_length(settings) / settings.walking_speed;
  Trajectory path =
      sample_way(settings, duration, [&](double time) { return walker(settings, time); });
  check_clearance(settings, path);
  return path;
}

Trajectory turntable_path(const InertialSettings& settings) {
  const double duration = settings.revolutions * settings.revolution_duration;
  const double rate = 2 * kPi / settings.revolution_duration;
  return sample_way(settings, duration, [&](double time) -> SE3 {
    // Rates without a common period, so that no two rounds are alike.
    const double angle = rate * time;
    const double radius = settings.circle_radius + settings.radial_sway * std::sin(2.7 * angle);
    const double height = settings.vertical_sway * std::sin(3.3 * angle + 0.5);
    const Eigen::Vector3d p(radius * std::cos(angle), radius * std::sin(angle), height);
    return {from_angles(angle + kPi + settings.gaze_sway * std::sin(4.1 * angle),
                        std::atan2(height, radius) + settings.gaze_sway * std::sin(4.9 * angle),
                        settings.gaze_sway * std::sin(3.7 * angle + 1)),
            p};
  });
}

}  // namespace chasles
