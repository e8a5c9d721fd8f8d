#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <chasles/slam/inertial_slam.hpp>
#include <chasles/slam/initialiser.hpp>
#include <chasles/slam/waiting_frames.hpp>

namespace chasles {

/// What an inertial run needs to know of the sensors.
struct InertialSensors {
  std::vector<Camera> cameras;
  ImuNoise noise;
  ImuBuffer::Options imu;
  double pixel_sigma = 1;  ///< [px]
};

/// From samples and frames to estimates, from the first to the last: finds a start, or takes one
/// that is given, runs the filter, and begins anew where the filter is lost. Position and heading
/// then go on from the last estimate that the frames agreed with, as uncertain as the time in
/// between makes them; a calibration that was learnt stays, as uncertain as it was then. Whatever
/// sensors deliver, nothing is thrown and all estimates are finite, their times rising strictly.
///
/// Recovered and counted: a sample that is not finite or not later (imu_counts); a frame that is
/// not later than the one before, or lies more than kLongestGap beyond the last sample, is dropped
/// (dropped_frames); samples that are missing for longer than kLongestGap end the part of the run
/// (resets), for nobody knows what happened in between; a shorter gap is bridged (ImuBuffer). A
/// given start without samples that near to it is given up (resets): the session finds its own.
class InertialSession {
 public:
  static constexpr Time kLongestGap = std::chrono::milliseconds(500);

  /// Throws UsageError for settings that cannot be used.
  InertialSession(const InertialSlamSettings& filter, const InitialiserSettings& start,
                  InertialSensors sensors, std::optional<InertialStart> given = std::nullopt);

  /// Told of every frame that the filter takes, with what became of its observations, before its
  /// estimate comes.
  using OutcomeObserver = std::function<void(const FeatureFrame&, std::span<const PixelOutcome>)>;
  void set_observer(OutcomeObserver observer) { observer_ = std::move(observer); }

  void process(const ImuSample& sample);
  /// The estimates that this frame brings: none before there is a start; with the start, those of
  /// all frames since the time that it is for. Where images are late by the IMU's clock (settings:
  /// time_offset, calibrate_time_offset) a frame waits until the samples reach up to it; its
  /// estimate comes with a later frame, or from finish().
  std::vector<Estimate> process(const FeatureFrame& frame);
  /// The estimates of the frames that still wait: no more samples will come.
  std::vector<Estimate> finish();

  bool running() const { return slam_ != nullptr; }
  /// What a start still needs.
  std::vector<Requirement> requirements() const;
  double waited() const;  ///< for a start, up to the present frame [s]
  int resets() const { return resets_; }
  int dropped_frames() const { return dropped_frames_; }
  ImuBuffer::Counts imu_counts() const;
  Eigen::Vector3d gyroscope_bias() const;  ///< zero before there is a start [rad/s]

  /// The landmarks of all parts of the run, nav's axes (InertialSlam::map_nav).
  std::vector<MapLandmark> map_nav() const;
  /// Those of them that the next frame may still touch.
  std::vector<LandmarkId> in_state() const;

 private:
  std::vector<Estimate> take(const FeatureFrame& frame);
  std::vector<Estimate> begin(InertialStart start);
  std::vector<Estimate> wait_for_given(const FeatureFrame& frame);
  std::optional<Estimate> step(const FeatureFrame& frame);
  void note_time(const ImuSample& sample);
  bool usable(const FeatureFrame& frame) const;
  Time clock(Time of_cameras) const;
  bool covered(const FeatureFrame& frame) const;
  void reset();
  void end_part();
  InertialStart continued(InertialStart start) const;
  bool believed(const Estimate& e);

  InertialSlamSettings settings_;
  InitialiserSettings start_settings_;
  InertialSensors sensors_;
  OutcomeObserver observer_;
  std::unique_ptr<InertialSlam> slam_;
  std::unique_ptr<Initialiser> initialiser_;
  std::optional<InertialStart> given_;
  std::deque<ImuSample> samples_;  ///< since the oldest frame that may begin the run
  std::deque<FeatureFrame> frames_;
  WaitingFrames<FeatureFrame> waiting_;
  std::optional<Time> waiting_since_;
  Time now_{};
  std::optional<Time> last_frame_, last_sample_;
  std::optional<Time> last_time_;   ///< of the last estimate
  std::optional<Estimate> last_;    ///< that was believed
  std::optional<Estimate> agreed_;  ///< and that the frames did not contradict
  std::vector<MapLandmark> earlier_map_;
  ImuBuffer::Counts earlier_counts_;
  int resets_ = 0, dropped_frames_ = 0;
  int contradictions_ = 0;  ///< frames that contradict the filter, less those that agree
};

}  // namespace chasles
