#pragma once

#include <atomic>
#include <chrono>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <chasles/pipeline/stamp_leaps.hpp>

#include "robot_latency.hpp"
#include "robot_log.hpp"
#include "robot_slam.hpp"

namespace chasles::app {

/// An image of a camera as it came.
struct ArrivedImage {
  Time time{};  ///< by the IMU's clock
  std::size_t camera = 0;
  GrayImage image;
  std::chrono::steady_clock::time_point arrived;
};

/// RobotSlam from a start or reset to the next: the order of the sensors, the estimator, and what
/// is known of it without waiting for it.
class RobotSession {
 public:
  RobotSession(std::unique_ptr<VisualInertialSlam> made, const RobotSetup& setup,
               const Recording& sensors, const InertialRunSettings& of_run,
               const RealtimeSlam::Callback& on_estimates);

  /// Takes the message, and what was held before it. Returns the first messages after a jump of the
  /// clock, which belong to another session. Throws the estimator's error.
  std::vector<ImuSample> feed(const ImuSample& sample);
  std::vector<ArrivedImage> feed(ArrivedImage image);

  /// All that waits is processed. An error of the estimator is kept: failure().
  void finish();
  std::exception_ptr failure() const { return failure_; }

  /// After it the callback is not called any more.
  void end_callbacks();

  bool has_estimate() const { return has_estimate_; }
  std::optional<PredictedState> predicted(Time time);
  /// All but `resets`. Waits for nothing that the estimator does.
  RobotReport report();

  RealtimeSlam& slam() { return *slam_; }
  /// Where the setup has an output.
  void write_run_folder(const std::filesystem::path& folder);

 private:
  void inspect(const Estimator& estimator);
  void note(std::span<const Estimate> estimates, VisualInertialSlam& of);
  template <typename Message>
  std::vector<Message> feed(Message message, StampLeaps<Message>& leaps);
  void take(const ImuSample& sample);
  void take(ArrivedImage&& image);
  void pass_on(std::vector<SensorEvent> events);

  std::mutex state_mutex_;  // of the next seven
  StatePredictor predictor_;
  std::optional<Estimate> last_;
  std::size_t samples_ = 0;
  SensorOrder::Counts counts_;
  int wrong_stamps_ = 0;
  std::string why_not_started_;
  int recoveries_ = 0;

  std::mutex order_mutex_;  // of the next five, and of passing on what the order returns
  SensorOrder order_;
  StampLeaps<ImuSample> leaps_of_samples_;
  std::vector<StampLeaps<ArrivedImage>> leaps_of_images_;
  bool finished_ = false;
  std::exception_ptr failure_;

  std::mutex callback_mutex_;  // of the next two
  bool ended_ = false;
  RealtimeSlam::Callback callback_;

  std::optional<RobotLog> log_;  // of the estimator's thread, as the next
  std::chrono::steady_clock::time_point last_inspection_;
  std::atomic<bool> has_estimate_ = false;
  RobotLatency latency_;
  std::optional<RealtimeSlam> slam_;  // last, because its thread uses all members above
};

}  // namespace chasles::app
