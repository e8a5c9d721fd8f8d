#include <algorithm>
#include <array>
#include <numbers>
#include <string_view>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <chasles/bags/bag_imu.hpp>
#include <chasles/bags/transform_tree.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles {
namespace {

// A shorter distance between two chips on a board does not count [m].
constexpr double kNoteworthyArm = 0.001;

bool is_measured(const TopicContents& topic, Eigen::Vector3d ImuSample::*part) {
  return std::ranges::any_of(topic.imu, [part](const ImuSample& s) {
    return (s.*part).allFinite() && !(s.*part).isZero(0);
  });
}

ImuParts parts(bool force, bool rate) {
  return force == rate ? ImuParts::kBoth : force ? ImuParts::kForces : ImuParts::kRates;
}

// The name in small letters, with one mark for either sensor; longer words come first.
std::string name_without_sensor(const std::string& name) {
  constexpr std::array<std::string_view, 8> kWords{
      "accelerometer", "acceleration", "gyroscope", "accel",
      "gyro",          "acc",          "gyr",       "angular_velocity"};
  std::string small = lower_case(name);
  for (const std::string_view word : kWords) {
    for (std::size_t at; (at = small.find(word)) != std::string::npos;) {
      small = small.substr(0, at).append(1, '*').append(small, at + word.size());
    }
  }
  return small;
}

}  // namespace

ImuParts measured_parts(const TopicContents& topic) {
  return parts(is_measured(topic, &ImuSample::specific_force_imu),
               is_measured(topic, &ImuSample::angular_rate_imu));
}

ImuParts stated_parts(const TopicContents& topic) {
  const ImuParts measured = measured_parts(topic);
  return measured != ImuParts::kBoth ? measured : parts(!topic.no_force, !topic.no_rate);
}

std::string parts_text(ImuParts parts) {
  return parts == ImuParts::kBoth     ? "accelerations and angular rates"
         : parts == ImuParts::kForces ? "accelerations alone"
                                      : "angular rates alone";
}

const TopicContents* partner_of(const TopicContents& topic,
                                const std::vector<const TopicContents*>& others) {
  if (others.size() == 1) return others.front();
  const std::string name = name_without_sensor(topic.topic.name);
  const TopicContents* found = nullptr;
  for (const TopicContents* other : others) {
    if (name_without_sensor(other->topic.name) != name) continue;
    if (found != nullptr) return nullptr;
    found = other;
  }
  return found;
}

SplitExtrinsics split_extrinsics(const TopicContents& accelerometer, const TopicContents& gyroscope,
                                 const BagContents& contents) {
  if (accelerometer.frame == gyroscope.frame) return {};
  const std::string frames =
      fmt::format("'{}' of {} to '{}' of {}", accelerometer.frame, accelerometer.topic.name,
                  gyroscope.frame, gyroscope.topic.name);
  SplitExtrinsics result;
  const auto known =
      transform_between(contents, gyroscope.frame, accelerometer.frame, result.remarks);
  if (!known) {
    result.remarks.push_back(fmt::format(
        "no static transform leads from {}: their axes are taken to be the same{}", frames,
        moving_advice(contents, gyroscope.frame, accelerometer.frame, "sensor")));
    return result;
  }
  result.gyro_T_accel = known->to_T_from;
  const double angle = Eigen::AngleAxisd(result.gyro_T_accel.R).angle() * 180 / std::numbers::pi;
  const double arm = result.gyro_T_accel.p.norm();
  if (angle > 0.01 || arm > kNoteworthyArm) {
    result.remarks.push_back(fmt::format(
        "by {} the accelerometer is turned by {:.4g} deg against the gyroscope, and {:.4g} mm from "
        "it ({}): the samples are along the gyroscope's axes, and the origin of the IMU is the "
        "accelerometer's",
        known->topic, angle, 1e3 * arm, frames));
  }
  return result;
}

}  // namespace chasles
