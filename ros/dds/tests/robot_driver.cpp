#include "robot_driver.hpp"

#include <algorithm>
#include <thread>

#include <fmt/format.h>

#include <chasles/codec/image_encode.hpp>

#include "cdr.hpp"
#include "messages_testing.hpp"

namespace chasles::test {
namespace {

std::string_view pixels_of(const GrayImage& image) {
  return {reinterpret_cast<const char*>(image.pixels.data()), image.pixels.size()};
}

}  // namespace

std::string camera_topic(std::size_t camera) {
  return fmt::format("/cam{}/image_raw{}", camera, camera == 1 ? "/compressed" : "");
}

RobotDriver::RobotDriver(FastClient& client, const Recording& recording, bool reliable, Time offset,
                         bool apart)
    : recording_(recording),
      offset_(offset),
      apart_(apart),
      imu_(client, {apart ? "rt/gyro" : "rt/imu0", "sensor_msgs::msg::dds_::Imu_"},
           {.reliable = reliable, .depth = reliable ? 0 : 100}) {
  if (apart) {
    accelerometer_ = std::make_unique<FastWriter>(
        client, WireTopic{"rt/accel", "sensor_msgs::msg::dds_::Imu_"},
        FastWriter::Options{.reliable = reliable, .depth = reliable ? 0 : 100});
  }
  for (std::size_t c = 0; c < recording.cameras.size(); ++c) {
    const char* type =
        c == 1 ? "sensor_msgs::msg::dds_::CompressedImage_" : "sensor_msgs::msg::dds_::Image_";
    cameras_.push_back(std::make_unique<FastWriter>(
        client, WireTopic{"rt" + camera_topic(c), type},
        FastWriter::Options{.reliable = reliable, .depth = reliable ? 0 : 10}));
  }
}

bool RobotDriver::await_bridge(const FastReader& diagnostics, std::chrono::seconds within) const {
  std::vector<std::string> topics{apart_ ? "/gyro" : "/imu0"};
  if (apart_) topics.emplace_back("/accel");
  for (std::size_t c = 0; c < cameras_.size(); ++c) topics.push_back(camera_topic(c));
  const auto hears = [](const Status& status, const std::string& topic) {
    const auto found = status.values.find("publishers of " + topic);
    return found != status.values.end() && found->second == "1";
  };
  const auto ready = [&] {
    const auto messages = diagnostics.messages();
    if (messages.empty()) return false;
    const Status last = status(messages.back().bytes);
    return std::ranges::all_of(topics, [&](const auto& topic) { return hears(last, topic); });
  };
  const auto end = Clock::now() + within;
  while (!ready() && Clock::now() < end) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  return ready();
}

void RobotDriver::play(double speed) {
  const auto begin = Clock::now();
  const Time first = first_event(recording_);
  const auto wait_for = [&](Time time) {
    if (speed <= 0) return;
    std::this_thread::sleep_until(
        begin + std::chrono::duration_cast<Clock::duration>(
                    std::chrono::duration<double>(to_seconds(time - first) / speed)));
  };
  EventStream events(recording_);
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) {
      wait_for(sample->time);
      send_sample(*sample);
    } else if (const auto* due = std::get_if<ImagesDue>(&*event)) {
      wait_for(due->time);
      send_frame(due->index);
    }
  }
}

void RobotDriver::send_sample(const ImuSample& sample) {
  ImuSample sent = sample;
  sent.time += offset_;
  if (!apart_) return imu_.write(imu_bytes(sent));
  ImuSample force = sent;
  force.angular_rate_imu.setZero();
  sent.specific_force_imu.setZero();
  imu_.write(imu_bytes(sent));
  if (samples_++ % 2 == 0) accelerometer_->write(imu_bytes(force));
}

void RobotDriver::send_frame(std::size_t index) {
  ImageFrame frame = recording_.images->read(index);
  frame.time += offset_;
  for (std::size_t c = 0; c < frame.images.size(); ++c) {
    const GrayImage& image = frame.images[c];
    cameras_[c]->write(c == 1 ? compressed_bytes(frame.time, "png", png_bytes(image))
                              : image_bytes(frame.time, static_cast<std::uint32_t>(image.width),
                                            static_cast<std::uint32_t>(image.height), "mono8",
                                            pixels_of(image)));
  }
  sent_[frame.time] = Clock::now();
}

bool RobotDriver::acknowledged(std::chrono::seconds within) const {
  if (accelerometer_ && !accelerometer_->acknowledged(within)) return false;
  return imu_.acknowledged(within) && std::ranges::all_of(cameras_, [&](const auto& camera) {
           return camera->acknowledged(within);
         });
}

}  // namespace chasles::test
