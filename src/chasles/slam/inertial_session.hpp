#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <chasles/estimate/slam_report.hpp>
#include <chasles/imu/sample_screen.hpp>
#include <chasles/imu/time_gaps.hpp>
#include <chasles/initialise/initialiser.hpp>
#include <chasles/slam/closure_trial.hpp>
#include <chasles/slam/inertial_slam.hpp>
#include <chasles/slam/waiting_frames.hpp>
#include <chasles/slam/waiting_samples.hpp>

namespace chasles {

/// The sensors of a visual-inertial run.
struct InertialSensors {
  std::vector<Camera> cameras;
  ImuNoise noise;
  ImuBuffer::Options imu;
  double pixel_sigma = 1;  ///< [px]
};

/// A whole run, from samples and frames to estimates. It initialises the filter or takes a given
/// start, runs the filter, and initialises it again where the filter is lost. Position and heading
/// then continue from the last estimate that agreed with the frames, with a covariance that grows
/// over the time in between. With Recognise::kAppearance and no prior map, it then looks for its
/// place in the map of the parts before (Estimate::in_map). An estimated calibration is kept with
/// its covariance. No sample or
/// frame throws; all estimates are finite, and their times rise strictly.
///
/// Recovered and counted:
/// - a sample that is no measurement: not finite, not later than the previous one, six zeros, a
/// spike, or of a frozen sensor (SampleScreen; SlamReport::imu);
/// - a frame that is not later than the previous one, or more than kLongestGap later than the last
/// sample, is dropped (SlamReport::dropped_frames);
/// - samples that are missing for longer than kLongestGap end this part of the run (resets),
/// because the motion in between is unknown; a shorter gap is bridged (ImuBuffer);
/// - a given start without samples within that time is dropped (resets), and the session
/// initialises itself.
class InertialSession {
 public:
  static constexpr Time kLongestGap = TimeGaps::kLongest;

  /// Throws UsageError for settings that cannot be used.
  InertialSession(const InertialSlamSettings& filter, const InitialiserSettings& start,
                  InertialSensors sensors, std::optional<InertialStart> given = std::nullopt,
                  std::shared_ptr<const LandmarkMap> prior = nullptr);

  /// Called for every frame that the filter takes, with the outcomes of its observations, before
  /// its estimate is returned.
  using OutcomeObserver = std::function<void(const FeatureFrame&, std::span<const PixelOutcome>)>;
  void set_observer(OutcomeObserver observer) { observer_ = std::move(observer); }

  /// The estimates of the frames that wait for this sample (below).
  std::vector<Estimate> process(const ImuSample& sample);
  /// A measurement before the start waits for it. Once it is found, an older one counts as late.
  void process(const TimedMeasurement& measurement);
  /// The estimates that this frame completes: none before the start; with the start, those of all
  /// frames since its time. Where images are late on the IMU's clock (settings: time_offset,
  /// calibrate_time_offset), a frame waits until the samples reach its time. Its estimate then
  /// comes with the sample that does, or from finish().
  std::vector<Estimate> process(const FeatureFrame& frame);
  /// The estimates of the frames that still wait; no more samples come.
  std::vector<Estimate> finish();

  bool running() const { return slam_ != nullptr; }
  /// The start of the present part, or of the last one; none before.
  const std::optional<InertialStart>& start() const { return start_; }
  /// The conditions of a start, with the last measured values.
  std::vector<Requirement> requirements() const;
  double waited() const;      ///< for a start, until the present frame [s]
  SlamReport report() const;  ///< of all parts
  /// What another run can recognise (InertialSlam::landmark_map) of a part of the run: one that has
  /// found its place in the prior map, else the one with most landmarks. Not of a part that was
  /// lost. Without sessions[].name. None before a start.
  std::optional<LandmarkMap> landmark_map() const;
  Eigen::Vector3d gyroscope_bias() const;  ///< zero before the start [rad/s]

  /// The landmarks of all parts of the run, in nav (InertialSlam::past_nav).
  std::vector<MapLandmark> map_nav() const { return past_nav().landmarks; }
  /// The same with the poses of all frames of all parts.
  Past::Estimates past_nav() const;
  /// Those of them that the next frame may still change.
  std::vector<LandmarkId> in_state() const;

 private:
  /// The parts before the present one, with what was dropped between and during them.
  struct Earlier {
    SlamReport report;
    Past::Estimates past;
    std::optional<LandmarkMap> map;  ///< of a part that was not lost
    bool map_placed = false;         ///< in the prior map
  };

  void take(const ImuSample& measured);
  std::vector<Estimate> take(const FeatureFrame& frame);
  std::vector<Estimate> take_covered();
  std::vector<Estimate> begin(InertialStart start);
  std::vector<Estimate> wait_for_given(const FeatureFrame& frame);
  std::optional<Estimate> step(const FeatureFrame& frame);
  bool usable(const FeatureFrame& frame) const;
  Time clock(Time of_cameras) const;
  bool covered(const FeatureFrame& frame) const;
  void reset(bool lost);
  void end_part(bool lost);
  SlamReport report_of_parts() const;
  void keep_map(bool lost);
  bool has_place() const;
  std::shared_ptr<const LandmarkMap> map_to_search() const;
  bool is_credible(const Estimate& e);

  InertialSlamSettings settings_;
  InitialiserSettings start_settings_;
  InertialSensors sensors_;
  SampleScreen screen_;  ///< the only one: buffers get what it releases
  bool screened_;        ///< the samples come from a screen, which counts what it leaves out
  TimeGaps gaps_;
  OutcomeObserver observer_;
  std::unique_ptr<InertialSlam> slam_;
  ClosureTrial trial_;
  std::unique_ptr<Initialiser> initialiser_;
  std::optional<InertialStart> given_, start_;
  std::shared_ptr<const LandmarkMap> prior_;
  std::vector<TimedMeasurement> timed_;  ///< as samples_
  WaitingSamples samples_;               ///< since the oldest frame that the run may start with
  std::deque<FeatureFrame> frames_;
  WaitingFrames<FeatureFrame> waiting_;
  std::optional<Time> waiting_since_;
  Time now_{};
  std::optional<Time> last_frame_;
  std::optional<Time> last_time_;   ///< of the last estimate
  std::optional<Estimate> last_;    ///< that was finite
  std::optional<Estimate> agreed_;  ///< and that agreed with the frames
  Earlier earlier_;
  std::shared_ptr<const LandmarkMap> seen_before_;  ///< what the run had mapped when it was lost
  std::optional<Time> first_time_;                  ///< of the first estimate
  int contradictions_ = 0;  ///< frames that contradict the filter minus those that agree
};

}  // namespace chasles
