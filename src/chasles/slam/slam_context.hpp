#pragma once

#include <vector>

#include <chasles/base/time.hpp>
#include <chasles/camera/camera.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/camera/track_noise.hpp>
#include <chasles/estimate/landmark_records.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/filter/scratch.hpp>
#include <chasles/slam/inertial_settings.hpp>

namespace chasles {

/// The camera that follows the observation's track, as a set: a frame in which it observes other
/// points says that it lost this one. None for a match: matches come and go while the track lasts.
inline CameraSet following(const PixelObservation& o) {
  return o.match.value_or(false) ? CameraSet{0} : camera_bit(o.camera);
}

/// Whether one of those that look would have seen the track. Any would, of one that has matches
/// alone: the camera that follows it is not among those of the run.
inline bool is_followed(CameraSet by, CameraSet looking) {
  return (by == 0 ? looking : by & looking) != 0;
}

/// What the steps of a frame share: the filter, the records of its landmarks, and what the settings
/// say of both. InertialSlam owns it and passes it to each step.
struct SlamContext {
  InertialSlamSettings settings;
  std::vector<Camera> cameras;
  double pixel_sigma = 1;  ///< [px]
  Ekf filter;
  LandmarkRecords records = {};                   ///< of the landmarks of the state
  int frame = 0;                                  ///< number of the present frame
  Time now{};                                     ///< of the state, by the cameras' clock
  mutable std::vector<double> gate_squares = {};  ///< of settings.gate; 0: not needed yet

  const State& state() const { return filter.state(); }
  const Camera& camera(int index) const { return cameras[static_cast<std::size_t>(index)]; }

  /// The present estimate of the cameras' time offset [s].
  double time_offset() const;
  /// Pixels determine no offset of more than half a second.
  bool has_sane_clock() const;
  /// The IMU's time of a camera time, by the present estimate of the time offset.
  Time clock(Time of_cameras) const;

  Linearisation linearisation() const;
  TrackNoise track_noise() const;
  /// Limit of a squared normalised innovation. Finite, so that an update computes every squared
  /// innovation, with a gate or without.
  double gate_square(int dof) const;
  /// Variance of a pixel beyond its scatter [px^2]. track_sigma stands for errors that many tracks
  /// share. A wrong track is one that differs from the others, so the gate compares it with
  /// pixel_sigma.
  double shared_variance() const;

  /// Makes the present pose a clone, at most once per frame.
  void keep_pose(Time time);
  /// Adds landmarks that this frame initialises, with their records. Returns their number.
  int add(const Reused<NewLandmark>& landmarks);
};

}  // namespace chasles
