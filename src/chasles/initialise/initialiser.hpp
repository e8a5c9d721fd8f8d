#pragma once

#include <deque>
#include <optional>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/estimate/requirement.hpp>
#include <chasles/filter/readout.hpp>
#include <chasles/imu/imu_buffer.hpp>
#include <chasles/initialise/inertial_start.hpp>
#include <chasles/initialise/initialiser_settings.hpp>

namespace chasles {

/// Finds the start of a visual-inertial run by static or dynamic initialisation
/// (docs/initialisation.md). Feed samples and frames as for InertialSlam, the samples up to a frame
/// before the frame, until it returns a start. Then feed the filter, from that start, with the
/// samples from shortly before start.time on and the frames from start.time on:
/// - dynamic: start.time is the first frame of the window. The covariance contains little of the
/// window's data, because the filter uses them again.
/// - static: start.time is the latest frame. The covariance is that of the standstill before it.
///
/// Recovered and counted: a sample that is not finite or not later (ImuBuffer); a frame that is not
/// later than the previous one, or has no samples around it, is ignored; an IMU gap restarts the
/// window. Deterministic.
class Initialiser {
 public:
  /// Numbers of events.
  struct Counts {
    int attempts = 0;
    int restarts = 0;        ///< windows discarded because of an IMU gap
    int ignored_frames = 0;  ///< out of order, or without samples
  };

  /// A noise density of 0 is replaced by a small one. Throws UsageError for settings, noise or a
  /// pixel_sigma [px] that cannot be used, or without a camera.
  Initialiser(const InitialiserSettings& settings, std::vector<Camera> cameras,
              const ImuNoise& noise, const ImuBuffer::Options& imu, double pixel_sigma);

  void add(const ImuSample& sample);
  std::optional<InertialStart> add(const FeatureFrame& frame);

  /// All conditions of the latest attempt, those of the static initialisation first. Before the
  /// first attempt: the number of frames that it needs.
  std::vector<Requirement> requirements() const;
  const Counts& counts() const { return counts_; }
  ImuBuffer::Counts imu_counts() const { return imu_.counts(); }

 private:
  bool take(const FeatureFrame& frame);
  std::optional<InertialStart> try_static();
  std::optional<InertialStart> try_dynamic();
  /// What the IMU measured while the images of these frames were read out; empty without a rolling
  /// shutter.
  std::vector<MeasuredReadout> readouts_of(const std::vector<FeatureFrame>& keyframes);
  void note(const char* way, std::vector<Requirement> requirements);
  void restart();

  InitialiserSettings settings_;
  std::vector<Camera> cameras_;
  ImuNoise noise_;
  ImuBuffer::Options imu_options_;
  double pixel_sigma_;
  ImuBuffer imu_;
  std::deque<ImuSample> samples_;    ///< the last ones, for the static initialisation
  std::deque<FeatureFrame> window_;  ///< without a gap of samples
  std::optional<Time> last_frame_;
  int since_attempt_ = 0;  ///< frames
  std::vector<Requirement> requirements_;
  Counts counts_;
};

}  // namespace chasles
