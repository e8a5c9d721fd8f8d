#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>

#include <chasles/lie/testing.hpp>
#include <chasles/report/testing.hpp>

namespace chasles::test {
namespace {

constexpr double kTurnRadius = 9;        // [m]
constexpr double kHeadingWalk = 3e-4;    // [rad], a frame
constexpr double kPositionWalk = 8e-3;   // [m], a frame
constexpr double kFramePeriod = 0.1036;  // [s]

struct Street {
  double length;  ///< [m], from corner to corner
  double turn;    ///< at its end: +1 left, -1 right, 0 none
};
constexpr std::array<Street, 9> kStreets = {
    {{130, 1}, {80, 1}, {50, -1}, {60, 1}, {120, 1}, {90, 1}, {40, -1}, {50, 1}, {90, 0}}};

/// Poses every `step` metres along the streets, with rounded corners.
std::vector<SE3> drive(double step) {
  std::vector<SE3> poses;
  double heading = 0, turn_before = 0;
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  const auto advance = [&](double length, double curvature) {
    for (double s = 0; s < length; s += step) {
      const Eigen::Vector3d way(std::cos(heading), std::sin(heading), 0);
      p += step * way;
      heading += step * curvature;
      const double sway = 0.012 * std::sin(0.11 * static_cast<double>(poses.size()));
      poses.push_back({so3::exp({0, 0, heading}) * so3::exp({sway, 0.4 * sway, 0}),
                       p + Eigen::Vector3d(0, 0, 1.2 * std::sin(p.x() / 60))});
    }
  };
  for (const Street& street : kStreets) {
    const double corners = kTurnRadius * ((turn_before != 0) + (street.turn != 0));
    advance(street.length - corners, 0);
    if (street.turn != 0) advance(std::numbers::pi / 2 * kTurnRadius, street.turn / kTurnRadius);
    turn_before = street.turn;
  }
  return poses;
}

/// The error of an odometry and its covariance, both propagated by the same linear model.
struct Drift {
  Vector6d error = Vector6d::Zero();
  Matrix6d P = Vector6d(1e-8, 1e-8, 1e-8, 1e-6, 1e-6, 1e-6).asDiagonal();

  void advance(const Eigen::Vector3d& way, double scale, Random& random) {
    Matrix6d F = Matrix6d::Identity();
    F.bottomLeftCorner<3, 3>() = -hat(way);
    Vector6d sigma;
    sigma << 0.3 * kHeadingWalk, 0.3 * kHeadingWalk, kHeadingWalk, kPositionWalk, kPositionWalk,
        kPositionWalk;
    sigma *= scale;
    error = F * error + sigma.cwiseProduct(random.normal_vector(6));
    P = F * P * F.transpose();
    P.diagonal() += sigma.cwiseAbs2();
  }

  SE3 estimate(const SE3& truth) const {
    return {so3::exp(-error.head<3>()) * truth.R, truth.p - error.tail<3>()};
  }
};

void add_counts(RunState& state, int index, Random& random) {
  const bool dark = index > 610 && index < 640;
  state.observations = dark ? 6 : 60 + static_cast<int>(random.uniform(0, 30));
  state.rejected = static_cast<int>(random.uniform(0, dark ? 4 : 5));
  state.added = static_cast<int>(random.uniform(0, 9));
  state.used = std::max(0, state.observations - state.rejected - state.added);
  state.nis_dof = 4 * state.used;
  state.nis = random.normal_vector(state.nis_dof).squaredNorm();
  state.in_state = state.observations + static_cast<int>(random.uniform(0, 20));
  state.landmarks = 5 * (index + 1);
  state.health = dark ? "degraded" : "ok";
  state.milliseconds = 2.4 + 0.02 * state.in_state + std::abs(0.25 * random.normal()) +
                       (random.uniform() > 0.997 ? 30 : 0);
  const double in_all = state.milliseconds;
  state.stages = {0.9 * in_all, 0.1 * in_all, 0.45 * in_all, 0.2 * in_all};
}

void add_extra(RunState& state, int index, Random& random) {
  const double converged = std::exp(-index / 120.0);
  state.extra = {
      6.8 + 0.1 * random.normal(), 0.02 * random.normal(), 0.02 * random.normal(), 0.002, -0.004,
      0.008 * (1 - converged)};
  state.extra_sigma = {0.1,
                       0.03,
                       0.03,
                       0.001 + 0.004 * converged,
                       0.001 + 0.004 * converged,
                       0.0006 + 0.004 * converged};
}

/// A point on a façade or on the ground beside the pose, uncertain along the line of sight.
RunLandmark landmark(int id, const SE3& truth, const Drift& drift, Random& random) {
  const double side = random.uniform() > 0.5 ? 1 : -1;
  const bool ground = random.uniform() > 0.8;
  const Eigen::Vector3d p_imu(random.uniform(6, 32),
                              side * (ground ? random.uniform(1.5, 7) : 9 + 2 * random.uniform()),
                              ground ? -1.4 : random.uniform(-1, 8));
  const Eigen::Vector3d ray = (truth.R * p_imu).normalized();
  const double range = p_imu.norm();
  const double along = 0.0011 * range * range, across = 0.004 * range;
  RunLandmark mark{.id = id, .p_world = drift.estimate(truth) * p_imu};
  mark.covariance = drift.P.bottomRightCorner<3, 3>() +
                    across * across * Eigen::Matrix3d::Identity() +
                    along * along * ray * ray.transpose();
  mark.observations = 3 + static_cast<int>(random.uniform(0, 20));
  return mark;
}

const char* const kSummary = R"({
  "version": "0.1.0", "ate_m": 0.871, "ate_posyaw_m": 0.904, "ate_first_pose_m": 2.13,
  "attitude_deg": 0.62, "rpe_100m_percent": 0.914, "nees_pose": 6.4, "nees_position": 3.2,
  "nees_attitude": 2.9, "nis_per_dof": 1.002, "frames": 1000, "landmarks": 5000,
  "seconds_wall": 2.91, "seconds_cpu": 2.84, "realtime_factor": 35.6, "health": "ok",
  "closures": [{"time_ns": 1317384526500000000, "seconds": 20.5, "landmarks": 6, "moved_m": 0.25,
    "turned_rad": 0.01, "chi2": 8.5, "chi2_dof": 12},
    {"time_ns": 1317384546000000000, "seconds": 40, "landmarks": 4, "moved_m": 0.125}],
  "settings": {"chart": "right-sen3", "mode": "slam", "gate": 0.99, "cameras": "stereo",
    "noise": {"velocity_m_s": 0.52, "rate_rad_s": 0.049, "pixels": [0.9, 0.4, 0.9, 0.4]}},
  "remarks": ["cam_T_imu is [C | rho] with the camera's position: taken as [C | -C rho].",
    "83 observations with a disparity below 0.5 px were dropped."]})";

}  // namespace

ReportRun synthetic_drive(const DriveOptions& options) {
  Random random(options.seed);
  const std::vector<SE3> poses = drive(670.0 / options.states);
  ReportRun report;
  report.summary = kSummary;
  Run& run = report.run;
  run.stage_names = {"front_end", "propagation", "update", "landmarks"};
  run.name = "Synthetic drive";
  run.extra_names = {"linear_velocity_x", "linear_velocity_y", "linear_velocity_z",
                     "gyro_bias_x",       "gyro_bias_y",       "gyro_bias_z"};
  Drift drift, dead;
  dead.error(2) = -0.01;
  for (int i = 0; i < options.states && i < static_cast<int>(poses.size()); ++i) {
    const SE3& pose = poses[static_cast<std::size_t>(i)];
    if (i > 0) {
      const Eigen::Vector3d way = pose.p - poses[static_cast<std::size_t>(i - 1)].p;
      drift.advance(way, 1, random);
      dead.advance(way, 8, random);
    }
    RunState state;
    state.time = from_seconds(1317384506 + kFramePeriod * i);
    state.world_T_imu = drift.estimate(pose);
    state.pose_covariance = drift.P;
    add_counts(state, i, random);
    add_extra(state, i, random);
    run.states.push_back(state);
    if (options.truth) run.truth.push_back({state.time, pose});
    if (options.dead_reckoning) run.dead_reckoning.push_back({state.time, dead.estimate(pose)});
    const int wanted =
        static_cast<int>(static_cast<long>(options.landmarks) * (i + 1) / options.states);
    while (static_cast<int>(run.landmarks.size()) < wanted) {
      run.landmarks.push_back(
          landmark(static_cast<int>(run.landmarks.size()) + 1, pose, drift, random));
      RunLandmark& mark = run.landmarks.back();
      if (options.initial && mark.id % 10 != 0) {
        mark.initial = {.p_world = mark.p_world + Eigen::Vector3d(4, -3, 1),
                        .covariance = 4 * mark.covariance};
      }
      mark.first_seen = state.time;
      mark.last_seen = state.time + from_seconds(kFramePeriod * mark.observations);
      mark.in_state = i + mark.observations >= options.states;
    }
  }
  if (options.prior_map) run.prior_map = synthetic_map(run.landmarks);
  return report;
}

MapSketch synthetic_map(const std::vector<RunLandmark>& landmarks) {
  MapSketch map{.world_T_map = {so3::exp({0, 0, 0.4}), {10, -20, 1}}, .sessions = {}, .points = {}};
  map.sessions = {{.name = "Monday", .begin = Time(0), .end = from_seconds(90), .cameras = 2},
                  {.name = "Tuesday",
                   .begin = from_seconds(1317384506),
                   .end = from_seconds(1317384806),
                   .cameras = 1}};
  const SE3 map_T_world = map.world_T_map.inverse();
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const RunLandmark& l = landmarks[i];
    const bool same = i % 3 == 0;
    map.points.push_back(
        {.id = same ? l.id : 1'000'000'000 + l.id,
         .session = i % 4 == 0 ? 0 : 1,
         .p_map = map_T_world * (l.p_world + Eigen::Vector3d(0.5, same ? 0 : 3, 0)),
         .covariance = map_T_world.R * l.covariance * map_T_world.R.transpose(),
         .own = static_cast<double>(i % 10) / 10,
         .observations = l.observations - (i % 6 == 0 ? 1 : 0),
         .views = 1 + static_cast<int>(i % 3)});
  }
  return map;
}

}  // namespace chasles::test
