#pragma once

#include <map>
#include <vector>

#include <chasles/base/time.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/estimate/closure.hpp>
#include <chasles/estimate/timed_measurement.hpp>
#include <chasles/imu/imu_buffer.hpp>

namespace chasles {

/// Adds the counts of another part of a run.
void add(const ImuBuffer::Counts& more, ImuBuffer::Counts& sum);

/// Counts and figures of a run, or of a part of it: what an estimator did with its input, besides
/// its estimates. What does not apply is 0 or empty.
struct SlamReport {
  ImuBuffer::Counts imu = {};
  TimedMeasurementCounts timed = {};
  int resets = 0;                      ///< of a lost filter
  int dropped_frames = 0;              ///< late, repeated, or without samples near
  PlaceCounts places = {};             ///< in the prior map
  std::vector<Closure> closures = {};  ///< of a filter that recognises landmarks by appearance
  /// Of the same: when a search found past landmarks (LoopCloser::recognised).
  std::vector<Time> recognised = {};
  /// Likewise: the landmarks of its recognised tracks, (id of the track, id of the landmark).
  std::map<LandmarkId, LandmarkId> known_as = {};

  /// Adds a later part of the run: counts add up, lists are appended. A place and the landmark of
  /// a track count as the run found them: the last place, the first landmark.
  void merge(const SlamReport& later);
};

}  // namespace chasles
