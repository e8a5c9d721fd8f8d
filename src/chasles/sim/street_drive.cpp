#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/sim/smoothstep.hpp>
#include <chasles/sim/street_drive.hpp>

namespace chasles {
namespace {

// Ratios of wavelengths without a short common period, so that no two waves stay in phase.
constexpr double kRoadRatio = 1.31;
constexpr double kPitchRatio = 0.73;

double wave_number(double wavelength) { return 2 * std::numbers::pi / wavelength; }

// A wave and its derivative by the distance.
struct Wave {
  double value, slope;
};
Wave wave(double amplitude, double wavelength, double way) {
  const double k = wave_number(wavelength);
  return {amplitude * std::sin(k * way), amplitude * k * std::cos(k * way)};
}

void append(StreetDrive& drive, double from, double to, double seconds) {
  if (seconds <= 0) return;
  double way = 0;
  if (!drive.speeds.empty()) {
    const SpeedPiece& last = drive.speeds.back();
    way = last.start_way + (last.from + last.to) / 2 * last.duration;
  }
  drive.speeds.push_back({drive.duration, seconds, way, from, to});
  drive.duration += seconds;
}

// The speeds at the two ends of a straight, and whether the car stops before the second.
struct Leg {
  double length, from, to;
  bool stop;
};

void append_leg(StreetDrive& drive, const StreetSettings& settings, const Leg& leg) {
  const double cruise = settings.cruise_speed;
  const auto seconds = [&](double a, double b) { return std::abs(a - b) / settings.acceleration; };
  const auto metres = [&](double a, double b) { return (a + b) / 2 * seconds(a, b); };
  const double needed = metres(leg.from, cruise) +
                        (leg.stop ? metres(cruise, 0) + metres(0, leg.to) : metres(cruise, leg.to));
  if (needed > leg.length) {
    throw UsageError(fmt::format(
        "simulation setting cruise_speed = {} m/s: a straight of {:.1f} m is too short to reach it "
        "and to brake again, which takes {:.1f} m; expected a lower speed, a higher acceleration "
        "(now {} m/s^2) or longer blocks",
        cruise, leg.length, needed, settings.acceleration));
  }
  append(drive, leg.from, cruise, seconds(leg.from, cruise));
  append(drive, cruise, cruise, (leg.length - needed) / cruise);
  if (leg.stop) {
    append(drive, cruise, 0, seconds(cruise, 0));
    append(drive, 0, 0, settings.stop_duration);
    append(drive, 0, leg.to, seconds(0, leg.to));
  } else {
    append(drive, cruise, leg.to, seconds(cruise, leg.to));
  }
}

struct Progress {
  double way, speed;
};

Progress progress_at(const StreetDrive& drive, double time) {
  const auto after = std::ranges::upper_bound(drive.speeds, time, {}, &SpeedPiece::start_time);
  const SpeedPiece& piece = after == drive.speeds.begin() ? *after : *std::prev(after);
  const double t = time - piece.start_time;
  const double x = t / piece.duration;
  const double change = piece.to - piece.from;
  return {piece.start_way + piece.from * t + change * piece.duration * smoothstep_integral(x),
          piece.from + change * smoothstep(x)};
}

}  // namespace

double Road::height(const Eigen::Vector2d& p) const {
  return amplitude * (std::sin(wave_number(wavelength) * p.x()) +
                      std::sin(wave_number(kRoadRatio * wavelength) * p.y()));
}

Eigen::Vector2d Road::gradient(const Eigen::Vector2d& p) const {
  const double kx = wave_number(wavelength);
  const double ky = wave_number(kRoadRatio * wavelength);
  return amplitude * Eigen::Vector2d(kx * std::cos(kx * p.x()), ky * std::cos(ky * p.y()));
}

StreetDrive make_street_drive(const StreetSettings& settings) {
  StreetDrive drive{.path = make_street_path(settings),
                    .speeds = {},
                    .road = {settings.road_amplitude, settings.road_wavelength},
                    .roll_amplitude = settings.roll_amplitude,
                    .pitch_amplitude = settings.pitch_amplitude,
                    .sway_wavelength = settings.sway_wavelength};
  const auto& pieces = drive.path.pieces;
  const double corner = settings.corner_speed;
  int corners = 0;
  double from = 0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (pieces[i].turn != 0) {
      append(drive, corner, corner, pieces[i].length / corner);
      from = corner;
    } else if (i + 1 == pieces.size()) {
      append_leg(drive, settings, {pieces[i].length, from, 0, false});
    } else {
      const bool stop = settings.stop_every > 0 && ++corners % settings.stop_every == 0;
      append_leg(drive, settings, {pieces[i].length, from, corner, stop});
    }
  }
  return drive;
}

DriveState state_at(const StreetDrive& drive, double time) {
  const auto [way, speed] = progress_at(drive, time);
  const PathPoint point = point_at(drive.path, way);
  const Wave roll = wave(drive.roll_amplitude, drive.sway_wavelength, way);
  const Wave pitch = wave(drive.pitch_amplitude, kPitchRatio * drive.sway_wavelength, way);
  const Eigen::Vector2d ahead(std::cos(point.heading), std::sin(point.heading));
  using Eigen::AngleAxisd, Eigen::Vector3d;

  DriveState state;
  state.heading = point.heading;
  state.world_T_imu.p << point.p, drive.road.height(point.p);
  state.world_T_imu.R =
      (AngleAxisd(point.heading, Vector3d::UnitZ()) * AngleAxisd(pitch.value, Vector3d::UnitY()) *
       AngleAxisd(roll.value, Vector3d::UnitX()))
          .toRotationMatrix();
  Vector3d v_world;
  v_world << ahead, drive.road.gradient(point.p).dot(ahead);
  state.linear_imu = speed * (state.world_T_imu.R.transpose() * v_world);
  // The rates of yaw, pitch and roll, each about its own axis in the car's frame.
  const double sr = std::sin(roll.value), cr = std::cos(roll.value);
  const double sp = std::sin(pitch.value), cp = std::cos(pitch.value);
  state.angular_imu = speed * Vector3d(roll.slope - sp * point.curvature,
                                       cr * pitch.slope + sr * cp * point.curvature,
                                       -sr * pitch.slope + cr * cp * point.curvature);
  return state;
}

}  // namespace chasles
