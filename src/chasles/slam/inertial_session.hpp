#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include <chasles/slam/inertial_slam.hpp>
#include <chasles/slam/initialiser.hpp>

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
/// then go on from the last estimate that was believed, as uncertain as the time in between makes
/// them.
class InertialSession {
 public:
  InertialSession(const InertialSlamSettings& filter, const InitialiserSettings& start,
                  InertialSensors sensors, std::optional<InertialStart> given = std::nullopt);

  void process(const ImuSample& sample);
  /// The estimates that this frame brings: none before there is a start; with the start, those of
  /// all frames since the time that it is for.
  std::vector<InertialEstimate> process(const FeatureFrame& frame);

  bool running() const { return slam_ != nullptr; }
  /// What a start still needs.
  std::vector<Requirement> requirements() const;
  double waited() const;  ///< for a start, up to the present frame [s]
  int resets() const { return resets_; }
  ImuBuffer::Counts imu_counts() const;
  Eigen::Vector3d gyroscope_bias() const;  ///< zero before there is a start [rad/s]

  /// The landmarks of all parts of the run, nav's axes (InertialSlam::map_nav).
  std::vector<MapLandmark> map_nav() const;

 private:
  std::vector<InertialEstimate> begin(InertialStart start);
  InertialEstimate step(const FeatureFrame& frame);
  void end_part();
  InertialStart continued(InertialStart start) const;
  bool believed(const InertialEstimate& e);

  InertialSlamSettings settings_;
  InitialiserSettings start_settings_;
  InertialSensors sensors_;
  std::unique_ptr<InertialSlam> slam_;
  std::unique_ptr<Initialiser> initialiser_;
  std::optional<InertialStart> given_;
  std::deque<ImuSample> samples_;  ///< since the oldest frame that may begin the run
  std::deque<FeatureFrame> frames_;
  std::optional<Time> waiting_since_;
  Time now_{};
  std::optional<InertialEstimate> last_;  ///< that was believed
  std::vector<MapLandmark> earlier_map_;
  ImuBuffer::Counts earlier_counts_;
  int resets_ = 0;
  int refused_frames_ = 0;  ///< in a row
};

}  // namespace chasles
