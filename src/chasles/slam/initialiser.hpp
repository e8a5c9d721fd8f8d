#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/imu/imu_buffer.hpp>
#include <chasles/slam/inertial_start.hpp>
#include <chasles/slam/initialiser_settings.hpp>
#include <chasles/slam/requirement.hpp>

namespace chasles {

/// Finds where an inertial run may begin, at rest or in motion (docs/initialisation.md): feed it
/// samples and frames as InertialSlam, the samples up to a frame before the frame, until it has a
/// start. Then feed the filter, from that start, with the samples from shortly before start.time on
/// and the frames from start.time on:
///   in motion, start.time is the first frame of the window, whose data the covariance counts
///   little, for the filter uses them all;
///   at rest it is the frame just given, and the covariance is that of the rest before it.
///
/// Recovered and counted: a sample that is not finite or not later (ImuBuffer), a frame that is not
/// later than the one before or has no samples around it is left out; an IMU gap begins the window
/// anew. Deterministic.
class Initialiser {
 public:
  /// How often.
  struct Counts {
    int attempts = 0;
    int restarts = 0;        ///< windows given up for an IMU gap
    int ignored_frames = 0;  ///< out of order, or without samples
  };

  /// A density of 0 is taken as a small one. UsageError for settings, noise or a pixel_sigma [px]
  /// that cannot be used, or without a camera.
  Initialiser(const InitialiserSettings& settings, std::vector<Camera> cameras,
              const ImuNoise& noise, const ImuBuffer::Options& imu, double pixel_sigma);

  void add(const ImuSample& sample);
  std::optional<InertialStart> add(const FeatureFrame& frame);

  /// All conditions of the latest attempt, those at rest first; empty before there was one.
  const std::vector<Requirement>& requirements() const { return requirements_; }
  /// The same in a sentence, of those not met, with the time since the first frame.
  std::string why_not() const;
  const Counts& counts() const { return counts_; }
  const ImuBuffer::Counts& imu_counts() const { return imu_.counts(); }

 private:
  bool take(const FeatureFrame& frame);
  std::optional<InertialStart> try_static();
  std::optional<InertialStart> try_in_motion();
  void note(const char* way, std::vector<Requirement> requirements);
  void restart();

  InitialiserSettings settings_;
  std::vector<Camera> cameras_;
  ImuNoise noise_;
  ImuBuffer::Options imu_options_;
  double pixel_sigma_;
  ImuBuffer imu_;
  std::deque<ImuSample> samples_;    ///< the last ones, for the start at rest
  std::deque<FeatureFrame> window_;  ///< no gap of samples in it
  std::optional<Time> began_, last_frame_;
  int since_attempt_ = 0;  ///< frames
  std::vector<Requirement> requirements_;
  Counts counts_;
};

}  // namespace chasles
