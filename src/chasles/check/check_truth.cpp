#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include <chasles/check/check_truth.hpp>
#include <chasles/lie/quaternion_order.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/recording/gravity.hpp>

namespace chasles {
namespace {

constexpr double kGravityLean = 3;               // [deg]
constexpr Time kTurn = std::chrono::seconds(1);  // over which turns are compared
constexpr std::size_t kFewestTurns = 5;
constexpr double kLeastTurn = 5;  // of turns that count [deg]

constexpr double kDegree = std::numbers::pi / 180;  // [rad]

void report_gravity(const Recording& recording, CheckReport& report) {
  const auto fit = fit_gravity(recording.truth, recording.imu);
  if (!fit) return;
  const double cosine = -fit->gravity_world.normalized().z();
  const double lean = std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
  report.facts.push_back({"truth", "gravity", fit->gravity_world.norm(), "m/s^2"});
  report.facts.push_back({"truth", "lean of gravity", lean, "deg"});
  if (lean <= kGravityLean) return;
  report.findings.push_back(
      {.severity = Severity::kWarning,
       .about = "truth",
       .what = fmt::format("{}{:.1f} deg from the truth's z axis", kLeanBegins, lean),
       .value = lean,
       .threshold = kGravityLean,
       .unit = "deg",
       .advice = "check the truth's frames: it must be the IMU's pose in a world with z up"});
}

// The turn that the gyroscope shows between two times, without its bias.
Eigen::Matrix3d integrated(const std::vector<ImuSample>& imu, Time begin, Time end) {
  Eigen::Matrix3d begin_R_now = Eigen::Matrix3d::Identity();
  auto sample = std::ranges::upper_bound(imu, begin, {}, &ImuSample::time);
  for (Time now = begin; sample != imu.end() && now < end; ++sample) {
    const Time next = std::min(sample->time, end);
    begin_R_now *= so3::exp(to_seconds(next - now) * sample->angular_rate_imu);
    now = next;
  }
  return begin_R_now;
}

// Turns over a second that both show, where the body turns.
std::vector<TwoTurns> turns_of(const Recording& recording) {
  std::vector<TwoTurns> turns;
  const Trajectory& truth = recording.truth;
  const std::vector<ImuSample>& imu = recording.imu;
  Time from = imu.front().time;
  for (std::size_t a = 0, b = 0; a < truth.size(); ++a) {
    if (truth[a].time < from) continue;
    while (b < truth.size() && truth[b].time < truth[a].time + kTurn) ++b;
    if (b == truth.size() || truth[b].time > imu.back().time) break;
    from = truth[a].time + kTurn / 2;
    if (truth[b].time > truth[a].time + 2 * kTurn) continue;
    const Eigen::Matrix3d a_R_b = integrated(imu, truth[a].time, truth[b].time);
    if (so3::log(a_R_b).norm() < kLeastTurn * kDegree) continue;
    turns.push_back({truth[a].pose.R, truth[b].pose.R, a_R_b});
  }
  return turns;
}

void report_turns(const Recording& recording, CheckReport& report) {
  const std::vector<TwoTurns> turns = turns_of(recording);
  if (turns.size() < kFewestTurns) return;
  const TurnErrors errors = turn_errors(turns);
  report.facts.push_back(
      {"truth", "turns in 1 s against the gyroscope's", errors.as_read / kDegree, "deg"});
}

// Of a truth with positions alone nothing here is known.
bool has_one_attitude(const Trajectory& truth) {
  constexpr double kSame = 1e-6;
  return std::ranges::all_of(truth, [&](const StampedPose& row) {
    return row.pose.R.isApprox(truth.front().pose.R, kSame);
  });
}

}  // namespace

void report_truth(const Recording& recording, CheckReport& report) {
  if (recording.imu.empty() || has_one_attitude(recording.truth)) return;
  report_gravity(recording, report);
  report_turns(recording, report);
}

}  // namespace chasles
