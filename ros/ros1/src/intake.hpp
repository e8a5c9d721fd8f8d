#pragma once

#include <atomic>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "node_diagnosis.hpp"
#include "parameters.hpp"
#include "publisher.hpp"
#include "robot_slam.hpp"
#include "topic_calibration.hpp"
#include "transport.hpp"

namespace chasles::ros1 {

/// The topics that the node reads. They have the names of the parameters, else those of the
/// calibration.
struct InputTopics {
  std::string imu;
  std::string accelerometer;         ///< empty: none of its own
  std::vector<std::string> cameras;  ///< with /compressed, if that is the transport
};
/// Throws UsageError for a topic that neither names, and where their number is not that of the
/// cameras.
InputTopics input_topics(const NodeParameters& parameters, const SensorCalibration& calibration);

/// Takes the messages of the IMU and of the cameras, each topic on a thread of its own, and passes
/// them on to SLAM. Without a calibration of the cameras messages wait until the topics have it.
class Intake {
 public:
  /// Reads the calibration, and subscribes. All must outlive this. Throws UsageError or InputError.
  Intake(Transport& transport, const NodeParameters& parameters, Publisher& publisher);
  Intake(const Intake&) = delete;
  Intake& operator=(const Intake&) = delete;

  /// Null while the cameras are not calibrated; waiting_for() says for what.
  app::RobotSlam* slam() const { return started_ ? slam_.get() : nullptr; }
  std::string waiting_for() const;
  /// When no handler runs any more: processes what waits. Throws where the start has failed.
  void finish();
  NodeCounts counts() const { return {.undecodable = undecodable_, .unset = unset_}; }

 private:
  using Take = std::function<void(const RawMessage&)>;

  void subscribe();
  void subscribe_to_calibration();
  void on_message(const RawMessage& message, const std::string& topic,
                  const std::function<void(const RosMessage&)>& take);
  void on_data(RawMessage message, Take take);
  void hold(RawMessage message, Take take);
  void try_to_start();
  void start(SensorCalibration calibration);
  void subscribe_to_imu();
  void take_sample(const RawMessage& message);
  void take_rate(const RawMessage& message);
  void take_force(const RawMessage& message);
  void note_frame(const std::string& frame, TopicContents& topic);
  void check_axes();
  void publish_predicted(const std::vector<Time>& times);
  void take_image(std::size_t camera, const RawMessage& message);
  bool has_stamp(const RosHeader& header);
  GrayImage decoded(std::size_t camera, const RawMessage& message, Time stamp);
  void report(const std::string& problem);

  Transport& transport_;
  const NodeParameters& parameters_;
  Publisher& publisher_;
  SensorCalibration calibration_;
  InputTopics topics_;
  std::vector<int> bits_;  ///< of each camera's 16-bit values; 0: not known yet

  mutable std::mutex start_mutex_;  // of the next four, until the start
  std::optional<TopicCalibration> by_topics_;
  std::deque<std::pair<RawMessage, Take>> held_;
  std::size_t held_bytes_ = 0;

  std::exception_ptr failure_;  ///< of a start by the topics, or of axes that differ

  // Of an accelerometer and a gyroscope with topics of their own: their names and frames, and the
  // static transforms.
  std::mutex axes_mutex_;
  TopicContents accelerometer_, gyroscope_;
  BagContents contents_;  // the transforms of /tf_static alone

  std::unique_ptr<app::RobotSlam> slam_;
  std::atomic<bool> started_ = false;
  std::atomic<int> undecodable_ = 0, unset_ = 0, reported_ = 0;
};

}  // namespace chasles::ros1
