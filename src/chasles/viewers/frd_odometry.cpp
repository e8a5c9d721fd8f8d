#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/viewers/frd_odometry.hpp>
#include <chasles/viewers/path_motion.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Our worlds have z up.
const Matrix3d kLocalAxes = Vector3d(1, -1, -1).asDiagonal();

// An axis of the IMU, with a sign; none for another text.
std::optional<Vector3d> axis_named(std::string_view name) {
  const double sign = name.starts_with('-') ? -1 : 1;
  if (name.starts_with('-') || name.starts_with('+')) name.remove_prefix(1);
  if (name.size() != 1 || name[0] < 'x' || name[0] > 'z') return std::nullopt;
  return Vector3d(sign * Vector3d::Unit(name[0] - 'x'));
}

// The times of what makes a path jump, in order.
std::vector<Time> closure_times(const std::string& summary) {
  std::vector<Time> times;
  const auto json = nlohmann::json::parse(summary, nullptr, false);
  if (!json.is_object()) return times;
  for (const auto& closure : json.value("closures", nlohmann::json::array())) {
    times.emplace_back(closure.at("time_ns").get<std::int64_t>());
  }
  std::ranges::sort(times);
  return times;
}

// Counts the jumps of the estimated path, state by state.
class Resets {
 public:
  explicit Resets(const std::string& summary) : closures_(closure_times(summary)) {}

  std::uint8_t after(const RunState& state) {
    const bool lost = state.health == "lost";
    if (was_lost_ && !lost) ++count_;
    was_lost_ = lost;
    for (; next_ < closures_.size() && closures_[next_] <= state.time; ++next_) ++count_;
    return count_;
  }

 private:
  std::vector<Time> closures_;
  std::size_t next_ = 0;
  bool was_lost_ = false;
  std::uint8_t count_ = 0;
};

Matrix6d frd_pose_covariance(const SmoothedPose& pose, const Matrix3d& body_R_imu) {
  Matrix6d J = Matrix6d::Zero();
  J.topRightCorner<3, 3>() = kLocalAxes;
  J.bottomLeftCorner<3, 3>() = body_R_imu * pose.world_T_imu.R.transpose();
  return J * pose.pose_covariance * J.transpose();
}

// The velocity of a state with its sigmas, along the axes of the body.
void set_velocity(const RunState& state, std::size_t column, const Matrix3d& body_R_world,
                  FrdOdometry& odometry) {
  const auto at = [&](const std::vector<double>& of) {
    return Vector3d(of[column], of[column + 1], of[column + 2]);
  };
  odometry.v_body = body_R_world * at(state.extra);
  const Vector3d variances = at(state.extra_sigma).array().square();
  odometry.velocity_covariance = body_R_world * variances.asDiagonal() * body_R_world.transpose();
}

bool is_all_finite(const FrdOdometry& o) {
  return o.v_body.allFinite() && o.rate_body.allFinite() && o.pose_covariance.allFinite() &&
         (!o.velocity_covariance || o.velocity_covariance->allFinite());
}

}  // namespace

Matrix3d frd_R_imu(std::string_view axes) {
  Matrix3d body_R_imu = Matrix3d::Zero();
  std::string_view rest = axes;
  bool known = true;
  for (int row = 0; row < 3; ++row) {
    const std::size_t comma = row < 2 ? rest.find(',') : rest.size();
    const auto axis = comma > rest.size() ? std::nullopt : axis_named(rest.substr(0, comma));
    known = known && axis;
    if (axis) body_R_imu.row(row) = *axis;
    rest.remove_prefix(std::min(rest.size(), comma == rest.npos ? rest.size() : comma + 1));
  }
  if (!known || body_R_imu.determinant() != 1) {
    throw UsageError(fmt::format(
        "--body: found '{}', expected the vehicle's forward, right and down as axes of the IMU, "
        "right-handed, such as x,-y,-z",
        axes));
  }
  return body_R_imu;
}

std::vector<FrdOdometry> frd_odometry(const ReportRun& run, RunPath path,
                                      const Matrix3d& body_R_imu) {
  if (!is_level(run.run)) {
    throw InputError(fmt::format(
        "run '{}' does not know which way is down, expected a run with an IMU", run.run.name));
  }
  const std::vector<SmoothedPose> poses = path_poses(run.run, path);
  if (poses.size() < 2) {
    throw InputError(fmt::format(
        "run '{}' has one pose, expected at least two: the format has velocities", run.run.name));
  }
  const auto velocity = extra_vector_at(run.run, "velocity");
  std::map<Time, const RunState*> states;
  for (const RunState& s : run.run.states) states.emplace(s.time, &s);
  Resets resets(run.summary);
  std::vector<FrdOdometry> all;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const SE3& world_T_imu = poses[i].world_T_imu;
    const PathMotion motion = motion_at(poses, i);
    FrdOdometry odometry{.time = poses[i].time,
                         .local_T_body = {.R = kLocalAxes * world_T_imu.R * body_R_imu.transpose(),
                                          .p = kLocalAxes * world_T_imu.p},
                         .v_body = body_R_imu * motion.velocity,
                         .rate_body = body_R_imu * motion.rate,
                         .pose_covariance = frd_pose_covariance(poses[i], body_R_imu),
                         .health = {}};
    const auto state = states.find(poses[i].time);
    if (state != states.end()) odometry.health = state->second->health;
    if (path == RunPath::kStates) {
      odometry.resets = resets.after(*state->second);
      if (velocity) {
        set_velocity(*state->second, *velocity, body_R_imu * world_T_imu.R.transpose(), odometry);
      }
    }
    if (is_all_finite(odometry)) all.push_back(odometry);
  }
  return all;
}

}  // namespace chasles
