#pragma once

#include <optional>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include <chasles/estimate/estimate.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/velocity/body_velocity_model.hpp>
#include <chasles/velocity/stereo_measurement.hpp>
#include <chasles/velocity/velocity_noise.hpp>
#include <chasles/velocity/velocity_settings.hpp>

namespace chasles {

/// Stereo-velocity SLAM. Feed velocities and frames in the order of time. The world is the IMU
/// frame at the first event.
///
/// Recovered and counted: an observation that is not finite, or that repeats a landmark in its
/// frame, is dropped. A landmark that returns after it was retired is initialised again. Time that
/// runs backwards and velocities that are not finite throw InputError.
class VelocitySlam {
 public:
  /// Throws UsageError for settings that cannot be used.
  VelocitySlam(const VelocitySlamSettings& settings, const StereoRig& rig,
               const VelocitySlamNoise& noise);

  void process(const BodyVelocity& velocity);
  Estimate process(const FeatureFrame& frame);

  /// The state, and the whole map with its covariance.
  const Ekf& filter() const { return filter_; }

  /// Every landmark as it was initialised, before its first update, in that order. A landmark that
  /// returns after it was retired is there twice, as in the map.
  std::span<const MapLandmark> initial_landmarks() const { return initial_; }

  /// Names of the components of Estimate::additive.
  std::vector<std::string> additive_names() const;

 private:
  using Observations = std::vector<const StereoObservation*>;
  struct Matched {
    std::vector<Measurement> known;  ///< of landmarks in the state
    Observations fresh;              ///< of landmarks that are not
  };

  void use_sample();
  void advance_to(Time time, const BodyVelocity& held);
  Observations usable(const FeatureFrame& frame) const;
  Matched match(const Observations& observations);
  int drop_outliers(std::vector<Measurement>& measurements) const;
  void choose(std::vector<Measurement>& measurements);
  int initialise(const Observations& fresh);
  void retire_unseen();
  void see(const FeatureFrame& frame, Estimate& estimate);
  void assess(Estimate& estimate);

  VelocitySlamSettings settings_;
  StereoRig rig_;
  VelocitySlamNoise noise_;
  BodyVelocityModel model_;
  StereoRows rows_;
  double gate_, loose_gate_;
  Ekf filter_;
  std::optional<Time> now_;
  std::optional<BodyVelocity> velocity_;  ///< the latest
  std::optional<Measurement> sample_;     ///< the same as a measurement, until it is applied
  int frame_ = 0;
  struct Last {
    int seen = 0, used = 0;  ///< numbers of frames
  };
  std::unordered_map<LandmarkId, Last> last_;  ///< of the landmarks of the state
  RecentUse recent_;
  std::vector<MapLandmark> initial_;
  double propagation_seconds_ = 0;  ///< since the last frame
};

}  // namespace chasles
