#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <chasles/recording/sensor_calibration.hpp>

#include "image_decoder.hpp"
#include "participant.hpp"
#include "robot_diagnosis.hpp"
#include "robot_slam.hpp"
#include "stamp_check.hpp"

namespace chasles::bridge {

struct BridgeOptions;

/// The topics of the sensors.
struct SensorTopics {
  std::string imu;
  std::string accelerometer;  ///< empty: none of its own
  std::vector<std::string> cameras;
};
/// Those of the options, else those that the calibration names, else /imu0 and /camN/image_raw.
/// Throws UsageError for another number of cameras than that of the calibration, and for a topic
/// that is given twice.
SensorTopics topics_of(const BridgeOptions& options, const SensorCalibration& calibration);

/// What the bridge subscribes to: it passes on the messages of drivers to SLAM.
class Inputs {
 public:
  /// Called for each sample of the IMU, after SLAM has it: its time, and the time since the one
  /// before [s].
  using OnSample = std::function<void(Time time, double period)>;

  Inputs(Participant& participant, const BridgeOptions& options, const SensorTopics& topics,
         app::RobotSlam& slam, OnSample on_sample);

  /// Passes on some of what has come of each topic. Returns the number of messages; 0: all has been
  /// passed on. Throws InputError where the first image of a camera cannot be decoded and there is
  /// no estimate yet.
  std::size_t take();

  /// Warns, once for each topic, where no message has come.
  void warn_of_silence();
  /// Adds the number of publishers of each topic, and of messages that were left out, with a
  /// warning of those since the last call.
  void describe(app::RobotDiagnosis& diagnosis);

 private:
  /// A topic and what has come on it.
  struct Source {
    std::string topic, type;
    dds_entity_t reader = 0;
    std::size_t messages = 0, damaged = 0;
    StampCheck stamps = {};
    std::size_t reported_damaged = 0, reported_unset = 0;  ///< at the last diagnosis
    bool warned = false;
  };

  template <typename Message>
  void subscribe(Participant& participant, const std::string& topic, const Delivery& delivery,
                 std::function<void(Source&, const Message&)> take);
  void subscribe_to_imu(Participant& participant, const SensorTopics& topics,
                        const Delivery& delivery);
  void take_sample(Source& source, const ImuMessage& message);
  void note_sample(Time time);
  template <typename Message>
  void take_image(Source& source, std::size_t camera, const Message& message);

  app::RobotSlam& slam_;
  std::vector<ImageDecoder> decoders_;
  std::vector<std::unique_ptr<Source>> sources_;
  std::vector<std::function<std::size_t()>> takes_;
  OnSample on_sample_;
  std::optional<Time> last_sample_;
};

}  // namespace chasles::bridge
