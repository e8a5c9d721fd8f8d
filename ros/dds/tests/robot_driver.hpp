#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>

#include <chasles/recording/recording.hpp>

#include "fast_client.hpp"

namespace chasles::test {

/// The drivers of a robot: they publish the samples and images of a recording over Fast DDS. The
/// second camera's images are compressed (PNG).
class RobotDriver {
 public:
  using Clock = std::chrono::steady_clock;

  /// `offset` is added to all stamps. `apart`: the gyroscope is on /gyro, and every second sample
  /// of the accelerometer on /accel, in place of /imu0.
  RobotDriver(FastClient& client, const Recording& recording, bool reliable, Time offset = {},
              bool apart = false);

  /// Whether within this time the bridge hears all topics: peers find each other at times of their
  /// own, so that its diagnostics must say it.
  bool await_bridge(const FastReader& diagnostics, std::chrono::seconds within) const;
  /// Publishes all, at this speed against the recording's own; 0: as fast as it goes.
  void play(double speed);
  /// Whether all of it has arrived.
  bool acknowledged(std::chrono::seconds within) const;

  /// When the last image of a frame was sent, by the frame's stamp.
  const std::map<Time, Clock::time_point>& sent() const { return sent_; }

 private:
  void send_sample(const ImuSample& sample);
  void send_frame(std::size_t index);

  const Recording& recording_;
  Time offset_;
  bool apart_;
  FastWriter imu_;  ///< or the gyroscope
  std::unique_ptr<FastWriter> accelerometer_;
  std::size_t samples_ = 0;
  std::vector<std::unique_ptr<FastWriter>> cameras_;
  std::map<Time, Clock::time_point> sent_;
};

/// "rt/cam0/image_raw"; the second camera's ends with /compressed.
std::string camera_topic(std::size_t camera);

}  // namespace chasles::test
