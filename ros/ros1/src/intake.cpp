#include "intake.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include <chasles/bags/bag_imu.hpp>
#include <chasles/bags/bag_topics.hpp>
#include <chasles/base/error.hpp>

#include "conversions.hpp"

namespace chasles::ros1 {
namespace {

// Messages that wait for a calibration: a few seconds of images [bytes].
constexpr std::size_t kMostHeld = 256 << 20;
// A topic may have thousands of damaged messages.
constexpr int kMostReported = 20;
// Messages that may wait for their thread, which decodes and passes on.
constexpr std::uint32_t kSampleQueue = 2000, kImageQueue = 20;
constexpr double kSameAxes = 1e-3;  // [rad]

RobotSetup setup_from(const NodeParameters& p, SensorCalibration calibration) {
  RobotSetup setup = p.robot;
  setup.calibration = std::move(calibration);
  return setup;
}

void check_type(const RawMessage& message, const std::string& expected, const std::string& where) {
  if (message.type == expected) return;
  throw InputError(
      fmt::format("{}: the messages are {}, expected {}", where, message.type, expected));
}

}  // namespace

InputTopics input_topics(const NodeParameters& p, const SensorCalibration& calibration) {
  InputTopics topics{.imu = p.imu_topic.empty() ? calibration.imu_topic : p.imu_topic,
                     .accelerometer = p.accelerometer_topic,
                     .cameras = p.camera_topics};
  if (topics.imu.empty()) {
    throw UsageError(
        "~imu_topic is missing, and the calibration names no topic (rostopic), expected the topic "
        "of the IMU");
  }
  if (topics.accelerometer == topics.imu) {
    throw UsageError(fmt::format(
        "~accelerometer_topic: found '{}', which is ~imu_topic, expected another topic, or none "
        "where one has both sensors",
        topics.accelerometer));
  }
  if (topics.cameras.empty()) topics.cameras = calibration.camera_topics;
  const std::size_t cameras = calibration.cameras.size();
  const bool unnamed = std::ranges::count(topics.cameras, "") > 0;
  if (topics.cameras.empty() || unnamed || (cameras > 0 && topics.cameras.size() != cameras)) {
    throw UsageError(fmt::format(
        "~camera_topics has {} topics{}, expected {}", p.camera_topics.size(),
        p.camera_topics.empty() ? ", and the calibration does not name all (rostopic)" : "",
        cameras == 0 ? "one for each camera"
                     : fmt::format("{}, as the calibration has cameras", cameras)));
  }
  if (p.image_transport == "compressed") {
    for (std::string& topic : topics.cameras) topic = raw_topic(topic) + "/compressed";
  }
  return topics;
}

Intake::Intake(Transport& transport, const NodeParameters& parameters, Publisher& publisher)
    : transport_(transport),
      parameters_(parameters),
      publisher_(publisher),
      calibration_(read_sensor_calibration(parameters.calibration, parameters.cameras)),
      topics_(input_topics(parameters, calibration_)),
      bits_(topics_.cameras.size(), parameters.image_bits) {
  accelerometer_.topic.name = topics_.accelerometer;
  gyroscope_.topic.name = topics_.imu;
  if (calibration_.cameras.empty()) {
    by_topics_.emplace(calibration_, topics_.imu, topics_.cameras, topics_.accelerometer);
  } else {
    start(calibration_);
  }
  subscribe();
}

std::string Intake::waiting_for() const {
  const std::lock_guard lock(start_mutex_);
  return by_topics_ ? by_topics_->missing() : "";
}

void Intake::subscribe() {
  const bool all = parameters_.robot.lossless;
  subscribe_to_calibration();
  for (std::size_t c = 0; c < topics_.cameras.size(); ++c) {
    transport_.subscribe(topics_.cameras[c], all ? 0 : kImageQueue,
                         [this, c](const RawMessage& message) {
                           on_data(message, [this, c](const RawMessage& m) { take_image(c, m); });
                         });
  }
  subscribe_to_imu();
}

// One topic, or one of the gyroscope and one of the accelerometer.
void Intake::subscribe_to_imu() {
  const std::uint32_t queue = parameters_.robot.lossless ? 0 : kSampleQueue;
  const auto subscribe = [&](const std::string& topic, void (Intake::*take)(const RawMessage&)) {
    transport_.subscribe(topic, queue, [this, take](const RawMessage& message) {
      on_data(message, [this, take](const RawMessage& m) { (this->*take)(m); });
    });
  };
  if (topics_.accelerometer.empty()) return subscribe(topics_.imu, &Intake::take_sample);
  subscribe(topics_.imu, &Intake::take_rate);
  subscribe(topics_.accelerometer, &Intake::take_force);
}

void Intake::subscribe_to_calibration() {
  transport_.subscribe("/tf_static", 0, [this](const RawMessage& message) {
    on_message(message, "/tf_static", [this](const RosMessage& ros) {
      const std::vector<RosTransform> transforms = ros_transforms(ros);
      publisher_.add_transforms(transforms);
      {
        const std::lock_guard lock(axes_mutex_);
        add_static_transforms(transforms, contents_.transforms);
        check_axes();
      }
      const std::lock_guard lock(start_mutex_);
      if (by_topics_) by_topics_->add_transforms(transforms);
      try_to_start();
    });
  });
  if (!by_topics_) return;
  const std::vector<std::string> infos = by_topics_->info_topics();
  for (std::size_t c = 0; c < infos.size(); ++c) {
    transport_.subscribe(infos[c], 10, [this, c, topic = infos[c]](const RawMessage& message) {
      if (started_) return;
      on_message(message, topic, [&](const RosMessage& ros) {
        check_type(message, "sensor_msgs/CameraInfo", ros.where);
        const RosCameraInfo info = ros_camera_info(ros);
        const std::lock_guard lock(start_mutex_);
        if (by_topics_) by_topics_->set_info(c, info);
        try_to_start();
      });
    });
  }
}

void Intake::on_message(const RawMessage& message, const std::string& topic,
                        const std::function<void(const RosMessage&)>& take) {
  try {
    take({.bytes = message.bytes, .wire = Wire::kRos1, .where = "topic " + topic});
  } catch (const std::exception& error) {
    report(error.what());
  }
}

// After the start no thread waits for another one here.
void Intake::on_data(RawMessage message, Take take) {
  if (!started_) {
    const std::lock_guard lock(start_mutex_);
    if (!started_) {
      hold(std::move(message), std::move(take));
      return;
    }
  }
  take(message);
}

// `start_mutex_` is locked.
void Intake::hold(RawMessage message, Take take) {
  held_bytes_ += message.bytes.size();
  held_.emplace_back(std::move(message), std::move(take));
  // What the message states of frames.
  if (by_topics_) held_.back().second(held_.back().first);
  while (!parameters_.robot.lossless && held_bytes_ > kMostHeld) {
    held_bytes_ -= held_.front().first.bytes.size();
    held_.pop_front();
  }
  try_to_start();
}

// `start_mutex_` is locked.
void Intake::try_to_start() {
  if (started_ || !by_topics_) return;
  std::optional<SensorCalibration> calibration = by_topics_->calibration();
  if (!calibration) return;
  by_topics_.reset();
  try {
    start(std::move(*calibration));
  } catch (...) {
    failure_ = std::current_exception();
    transport_.stop();
  }
}

void Intake::start(SensorCalibration calibration) {
  for (const std::string& remark : calibration.remarks) transport_.log(LogLevel::kInfo, remark);
  slam_ = std::make_unique<RobotSlam>(
      setup_from(parameters_, std::move(calibration)),
      RobotSlam::Callbacks{
          .on_estimates = [this](std::span<const Estimate> estimates,
                                 VisualInertialSlam& slam) { publisher_.publish(estimates, slam); },
          .on_reset =
              [this](const std::string& why) {
                transport_.log(LogLevel::kWarning, why + ": the run begins anew");
                publisher_.reset();
              },
          .on_output =
              [this](const std::string& sentence, bool written) {
                transport_.log(written ? LogLevel::kInfo : LogLevel::kError, sentence);
              }});
  publisher_.set_rate_noise(slam_->imu_noise().gyroscope_noise_density);
  for (const auto& [message, take] : std::exchange(held_, {})) take(message);
  started_ = true;
}

void Intake::take_sample(const RawMessage& message) {
  on_message(message, topics_.imu, [&](const RosMessage& ros) {
    check_type(message, "sensor_msgs/Imu", ros.where);
    const RosHeader header = ros_header(ros);
    publisher_.set_imu_frame(header.frame);
    if (!slam_) {
      by_topics_->set_imu_frame(header.frame);
      return;
    }
    if (!has_stamp(header)) return;
    const ImuSample sample = ros_imu(ros);
    slam_->add(sample);
    publish_predicted({sample.time});
  });
}

void Intake::publish_predicted(const std::vector<Time>& times) {
  for (const Time time : times) {
    if (const auto state = slam_->predicted(time)) publisher_.publish(*state);
  }
}

void Intake::take_rate(const RawMessage& message) {
  on_message(message, topics_.imu, [&](const RosMessage& ros) {
    check_type(message, "sensor_msgs/Imu", ros.where);
    const RosHeader header = ros_header(ros);
    publisher_.set_imu_frame(header.frame);
    if (!slam_) return by_topics_->set_imu_frame(header.frame);
    note_frame(header.frame, gyroscope_);
    if (!has_stamp(header)) return;
    publish_predicted(
        slam_->add_rate({.time = header.stamp, .value = ros_imu(ros).angular_rate_imu}));
  });
}

void Intake::note_frame(const std::string& frame, TopicContents& topic) {
  if (frame.empty() || !topic.frame.empty()) return;  // only this topic's thread writes
  const std::lock_guard lock(axes_mutex_);
  topic.frame = frame;
  check_axes();
}

// With a calibration file the samples are taken before it is known what /tf_static will say: axes
// that differ end the node. `axes_mutex_` is locked.
void Intake::check_axes() {
  if (calibration_.cameras.empty() || accelerometer_.frame.empty() || gyroscope_.frame.empty()) {
    return;
  }
  const SplitExtrinsics extrinsics = split_extrinsics(accelerometer_, gyroscope_, contents_);
  if (failure_ || extrinsics.gyro_T_accel.R.isIdentity(kSameAxes)) return;
  failure_ = std::make_exception_ptr(InputError(fmt::format(
      "~accelerometer_topic: {}; expected the same axes for both: use the driver's topic with both "
      "sensors, or a calibration by the topics (imu.yaml alone), which turns them",
      extrinsics.remarks.front())));
  transport_.stop();
}

void Intake::take_force(const RawMessage& message) {
  on_message(message, topics_.accelerometer, [&](const RosMessage& ros) {
    check_type(message, "sensor_msgs/Imu", ros.where);
    const RosHeader header = ros_header(ros);
    if (!slam_) return by_topics_->set_accelerometer_frame(header.frame);
    note_frame(header.frame, accelerometer_);
    if (!has_stamp(header)) return;
    publish_predicted(
        slam_->add_force({.time = header.stamp, .value = ros_imu(ros).specific_force_imu}));
  });
}

void Intake::take_image(std::size_t camera, const RawMessage& message) {
  const auto arrived = RobotSlam::Clock::now();
  on_message(message, topics_.cameras[camera], [&](const RosMessage& ros) {
    const RosHeader header = ros_header(ros);
    if (!slam_) {
      by_topics_->set_image_frame(camera, header.frame);
      return;
    }
    if (!has_stamp(header)) return;
    slam_->add(camera, header.stamp, decoded(camera, message, header.stamp), arrived);
  });
}

bool Intake::has_stamp(const RosHeader& header) {
  if (header.stamp != Time{}) return true;
  ++unset_;
  return false;
}

// An image that is damaged is missing, as in a recording.
GrayImage Intake::decoded(std::size_t camera, const RawMessage& message, Time stamp) {
  const Camera& expected = slam_->cameras()[camera];
  const ImageSize size{.width = expected.width, .height = expected.height};
  const std::string where =
      fmt::format("topic {} at {} ns", topics_.cameras[camera], stamp.count());
  try {
    if (bits_[camera] == 0) bits_[camera] = bits_of(message, size, where);
    return image_of(message, size, bits_[camera], where);
  } catch (const InputError& error) {
    ++undecodable_;
    report(error.what());
    return {};
  }
}

void Intake::report(const std::string& problem) {
  const int number = ++reported_;
  if (number > kMostReported) return;
  transport_.log(LogLevel::kError, problem);
  if (number == kMostReported) transport_.log(LogLevel::kError, "further ones are only counted");
}

void Intake::finish() {
  if (failure_) std::rethrow_exception(failure_);
  if (slam()) slam()->finish();
}

}  // namespace chasles::ros1
