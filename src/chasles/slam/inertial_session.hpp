#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <chasles/imu/sample_gaps.hpp>
#include <chasles/initialise/initialiser.hpp>
#include <chasles/slam/closure_trial.hpp>
#include <chasles/slam/inertial_slam.hpp>
#include <chasles/slam/waiting_frames.hpp>

namespace chasles {

/// The sensors of a visual-inertial run.
struct InertialSensors {
  std::vector<Camera> cameras;
  ImuNoise noise;
  ImuBuffer::Options imu;
  double pixel_sigma = 1;  ///< [px]
};

/// Adds the counts of another part of a run.
void add(const ImuBuffer::Counts& more, ImuBuffer::Counts& sum);

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
/// spike, or of a frozen sensor (SampleScreen; imu_counts);
/// - a frame that is not later than the previous one, or more than kLongestGap later than the last
/// sample, is dropped (dropped_frames);
/// - samples that are missing for longer than kLongestGap end this part of the run (resets),
/// because the motion in between is unknown; a shorter gap is bridged (ImuBuffer);
/// - a given start without samples within that time is dropped (resets), and the session
/// initialises itself.
class InertialSession {
 public:
  static constexpr Time kLongestGap = SampleGaps::kLongest;

  /// Throws UsageError for settings that cannot be used.
  InertialSession(const InertialSlamSettings& filter, const InitialiserSettings& start,
                  InertialSensors sensors, std::optional<InertialStart> given = std::nullopt,
                  std::shared_ptr<const LandmarkMap> prior = nullptr);

  /// Called for every frame that the filter takes, with the outcomes of its observations, before
  /// its estimate is returned.
  using OutcomeObserver = std::function<void(const FeatureFrame&, std::span<const PixelOutcome>)>;
  void set_observer(OutcomeObserver observer) { observer_ = std::move(observer); }

  void process(const ImuSample& sample);
  /// A measurement before the start waits for it. Once it is found, an older one counts as late.
  void process(const TimedMeasurement& measurement);
  /// The estimates that this frame completes: none before the start; with the start, those of all
  /// frames since its time. Where images are late on the IMU's clock (settings: time_offset,
  /// calibrate_time_offset), a frame waits until the samples reach its time. Its estimate then
  /// comes with a later frame, or from finish().
  std::vector<Estimate> process(const FeatureFrame& frame);
  /// The estimates of the frames that still wait; no more samples come.
  std::vector<Estimate> finish();

  bool running() const { return slam_ != nullptr; }
  /// The conditions of a start, with the last measured values.
  std::vector<Requirement> requirements() const;
  double waited() const;  ///< for a start, until the present frame [s]
  int resets() const { return resets_; }
  int dropped_frames() const { return dropped_frames_; }
  std::vector<Closure> closures() const;
  std::vector<Time> recognised() const;  ///< as LoopCloser::recognised, of all parts
  /// As LoopCloser::known_as, of all parts.
  std::map<LandmarkId, LandmarkId> known_as() const;
  /// What another run can recognise (InertialSlam::landmark_map) of a part of the run: one that has
  /// found its place in the prior map, else the one with most landmarks. Not of a part that was
  /// lost. Without sessions[].name. None before a start.
  std::optional<LandmarkMap> landmark_map() const;
  PlaceCounts place_counts() const;  ///< in the prior map, of all parts; `placed` of the last one
  ImuBuffer::Counts imu_counts() const;
  TimedMeasurementCounts timed_counts() const;
  Eigen::Vector3d gyroscope_bias() const;  ///< zero before the start [rad/s]

  /// The landmarks of all parts of the run, in nav (InertialSlam::past_nav).
  std::vector<MapLandmark> map_nav() const { return past_nav().landmarks; }
  /// The same with the poses of all frames of all parts.
  Past::Estimates past_nav() const;
  /// Those of them that the next frame may still change.
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
  void reset(bool lost);
  void end_part(bool lost);
  void keep_map(bool lost);
  std::shared_ptr<const LandmarkMap> map_to_search() const;
  bool is_credible(const Estimate& e);

  InertialSlamSettings settings_;
  InitialiserSettings start_settings_;
  InertialSensors sensors_;
  SampleGaps gaps_;
  OutcomeObserver observer_;
  std::unique_ptr<InertialSlam> slam_;
  ClosureTrial trial_;
  std::unique_ptr<Initialiser> initialiser_;
  std::optional<InertialStart> given_;
  std::shared_ptr<const LandmarkMap> prior_;
  std::vector<TimedMeasurement> timed_;  ///< as samples_
  std::deque<ImuSample> samples_;        ///< since the oldest frame that the run may start with
  std::deque<FeatureFrame> frames_;
  WaitingFrames<FeatureFrame> waiting_;
  std::optional<Time> waiting_since_;
  Time now_{};
  std::optional<Time> last_frame_, last_sample_;
  std::optional<Time> last_time_;   ///< of the last estimate
  std::optional<Estimate> last_;    ///< that was finite
  std::optional<Estimate> agreed_;  ///< and that agreed with the frames
  Past::Estimates earlier_;
  std::vector<Closure> earlier_closures_;
  std::vector<Time> earlier_recognised_;
  std::map<LandmarkId, LandmarkId> earlier_known_as_;
  std::optional<LandmarkMap> earlier_map_;          ///< of a part that was not lost
  bool earlier_map_placed_ = false;                 ///< in the prior map
  std::shared_ptr<const LandmarkMap> seen_before_;  ///< what the run had mapped when it was lost
  PlaceCounts earlier_place_counts_;
  std::optional<Time> first_time_;  ///< of the first estimate
  ImuBuffer::Counts earlier_counts_;
  TimedMeasurementCounts earlier_timed_counts_;
  int resets_ = 0, dropped_frames_ = 0;
  int contradictions_ = 0;  ///< frames that contradict the filter minus those that agree
};

}  // namespace chasles
