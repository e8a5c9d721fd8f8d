#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Cholesky>

#include <chasles/base/constants.hpp>
#include <chasles/initialise/initialiser.hpp>
#include <chasles/numeric/spline.hpp>
#include <chasles/recording/recording.hpp>

// Shared by the tests of the initialisation.
namespace chasles::test {

using Vector11d = Eigen::Matrix<double, 11, 1>;
using Matrix11d = Eigen::Matrix<double, 11, 11>;

/// The result of an initialisation from some time of a recording on.
struct StartOutcome {
  std::optional<InertialStart> start;
  double seconds = 0;  // until the start
  Initialiser::Counts counts;
  std::vector<Requirement> requirements;
  std::string why_not;
  double slowest = 0;  // longest time of a call [s]
};

inline StartOutcome initialise(const Recording& recording, double from, double limit,
                               const InitialiserSettings& settings) {
  Initialiser initialiser(settings, recording.cameras, *recording.imu_noise,
                          {.convention = recording.imu_convention},
                          recording.single_pixel_sigma.value_or(1));
  const Time begin = recording.frames.front().time + from_seconds(from);
  StartOutcome outcome;
  EventStream events(recording);
  while (auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) {
      if (sample->time >= begin - from_seconds(0.05)) initialiser.add(*sample);
    }
    const auto* frame = std::get_if<FeatureFrame>(&*event);
    if (!frame || frame->time < begin) continue;
    outcome.seconds = to_seconds(frame->time - begin);
    if (outcome.seconds > limit) break;
    const auto before = std::chrono::steady_clock::now();
    outcome.start = initialiser.add(*frame);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - before;
    outcome.slowest = std::max(outcome.slowest, took.count());
    if (outcome.start) break;
  }
  outcome.counts = initialiser.counts();
  outcome.requirements = initialiser.requirements();
  outcome.why_not = why_not_initialised(outcome.seconds, outcome.requirements);
  return outcome;
}

/// Errors of a start in its own nav, whose heading is arbitrary.
struct StartError {
  Vector11d error = Vector11d::Zero();  // tilt, velocity, biases (0 where unknown)
  Matrix11d covariance = Matrix11d::Zero();
  double speed = 0, scale = 0;
  double tilt() const { return error.head<2>().norm(); }
  double velocity() const { return error.segment<3>(2).norm(); }
  double gyroscope() const { return error.tail<3>().norm(); }
  double nees() const { return error.dot(covariance.ldlt().solve(error)); }
};

inline StartError error_of(const InertialStart& start, const Recording& recording,
                           const Spline& motion) {
  const Motion truth = motion_at(motion, to_seconds(start.time - motion.start));
  const Eigen::Matrix3d difference = start.nav_T_imu.R * truth.world_T_imu.R.transpose();
  const double yaw =
      std::atan2(difference(1, 0) - difference(0, 1), difference(0, 0) + difference(1, 1));
  const Eigen::Matrix3d nav_R_world = so3::exp({0, 0, yaw});
  const Eigen::Vector3d v = nav_R_world * truth.v_world;
  StartError e;
  e.error.head<2>() =
      so3::log(nav_R_world * truth.world_T_imu.R * start.nav_T_imu.R.transpose()).head<2>();
  e.error.segment<3>(2) = v - start.v_nav;
  const auto known =
      std::ranges::lower_bound(recording.true_motion, start.time, {}, &TrueMotion::time);
  if (known != recording.true_motion.end()) {
    e.error.segment<3>(5) = known->accelerometer_bias - start.accelerometer_bias;
    e.error.tail<3>() = known->gyroscope_bias - start.gyroscope_bias;
  }
  e.speed = v.norm();
  e.scale = start.v_nav.norm() / std::max(e.speed, 1e-9);
  Eigen::Matrix<double, 15, 11> pick = Eigen::Matrix<double, 15, 11>::Zero();
  pick.topLeftCorner<2, 2>().setIdentity();
  pick.bottomRightCorner<9, 9>().setIdentity();
  e.covariance = pick.transpose() * *start.covariance * pick;
  return e;
}

inline double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values.empty() ? std::nan("") : values[values.size() / 2];
}

/// Statistics of many starts.
struct Study {
  int tried = 0, started = 0;
  std::vector<double> seconds, tilt, velocity, scale, gyroscope, nees;
  double slowest = 0;

  void add(const StartOutcome& outcome, const Recording& recording, const Spline& motion) {
    ++tried;
    slowest = std::max(slowest, outcome.slowest);
    if (!outcome.start) return;
    ++started;
    const StartError e = error_of(*outcome.start, recording, motion);
    seconds.push_back(outcome.seconds);
    tilt.push_back(e.tilt());
    velocity.push_back(e.velocity());
    scale.push_back(std::abs(e.scale - 1));
    gyroscope.push_back(e.gyroscope());
    nees.push_back(e.nees());
  }
  double mean_nees() const {
    double sum = 0;
    for (const double value : nees) sum += value / static_cast<double>(nees.size());
    return sum;
  }
  void print(const std::string& name) const {
    const auto most = [](const std::vector<double>& v) {
      return v.empty() ? std::nan("") : *std::ranges::max_element(v);
    };
    std::cout << name << ": " << started << " of " << tried << ", after " << median(seconds)
              << " s; median/worst tilt " << kDegrees * median(tilt) << "/" << kDegrees * most(tilt)
              << " deg, velocity " << median(velocity) << "/" << most(velocity) << " m/s, scale "
              << 100 * median(scale) << "/" << 100 * most(scale) << " %, gyroscope bias "
              << median(gyroscope) << "/" << most(gyroscope) << " rad/s; mean NEES " << mean_nees()
              << "; slowest call " << 1e3 * slowest << " ms\n";
  }
};

}  // namespace chasles::test
