#pragma once

#include <optional>
#include <vector>

#include <chasles/estimate/recent_tracks.hpp>
#include <chasles/slam/clone_window.hpp>
#include <chasles/slam/undelayed_initialiser.hpp>

namespace chasles {

/// Updates with tracks whose points are not in the state (MSCKF: Mourikis & Roumeliotis 2007). The
/// views of a track wait, with clones of the poses. Where they determine the depth, the track
/// becomes a landmark; where the track ends earlier, its residuals are projected onto the null
/// space of the point and update the clones. Every observation is used once.
class TrackUpdater {
 public:
  explicit TrackUpdater(const InertialSlamSettings& settings);

  /// An observation whose point is not in the state. A view waits only if the pose is a clone.
  void add(const SlamContext& x, const PixelObservation& o, bool augmented);
  /// The null-space updates of this frame, and the tracks that become landmarks. `looking`: the
  /// cameras that observe anything. Returns the number of landmarks.
  int update(SlamContext& x, CameraSet looking, const CloneWindow& clones);
  /// With few landmarks, as at the start or after a sharp turn, tracks of this frame's clone are
  /// initialised without delay. Returns their number.
  int initialise_missing(SlamContext& x, const UndelayedInitialiser& initialiser);
  /// Ends the frame.
  TrackUse use(const SlamContext& x);

  const Reused<WaitingTrack>& tracks() const { return tracks_; }

 private:
  WaitingTrack& track_of(const SlamContext& x, LandmarkId id);
  void remove_ended();
  bool has_room(const SlamContext& x) const;
  bool find_start(const SlamContext& x, const WaitingTrack& track);
  bool is_certain(const SlamContext& x) const;
  bool is_somewhere(const SlamContext& x) const;
  bool take_projected(const SlamContext& x);
  int add_and_update(SlamContext& x);

  Reused<WaitingTrack> tracks_;         ///< in the order of their ids
  std::optional<RecentTracks> recent_;  ///< where the filter works mainly with tracks
  Reused<NewLandmark> landmarks_;       ///< that this frame initialises
  Reused<Measurement> projected_;       ///< residuals of this frame
  MultiViewStart start_;                ///< of the present track
  MultiViewScratch scratch_;
};

}  // namespace chasles
