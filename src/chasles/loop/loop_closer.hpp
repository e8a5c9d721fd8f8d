#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/estimate/closure.hpp>
#include <chasles/estimate/landmark_records.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/loop/landmark_map.hpp>
#include <chasles/loop/loop_matching.hpp>
#include <chasles/loop/map_placer.hpp>
#include <chasles/loop/placed_map.hpp>
#include <chasles/loop/recognise.hpp>
#include <chasles/loop/saved_map.hpp>
#include <chasles/loop/spatial_choice.hpp>

namespace chasles {

/// Settings of a LoopCloser; their meaning is that of InertialSlamSettings.
struct LoopSettings {
  Recognise recognise = Recognise::kNone;
  PriorMapUse prior_map = PriorMapUse::kEstimated;
  int recognisable = 1500;
  int max_rejections = 5;
  LoopNoise noise = {};
};

/// A frame, as the filter has it.
struct FrameMoment {
  int frame = 0;  ///< number
  Time now{};     ///< by the cameras' clock
  Time by_imu{};  ///< by the IMU's
};

/// Past landmarks that a search has found in view, before they return into the filter.
struct LoopReturn {
  std::vector<int> numbers;  ///< in Ekf::past(); by their ids
  /// By their appearance:
  std::vector<ObservedLandmark> observed = {};
  std::vector<LoopCandidate> candidates = {};
  LoopInnovations innovations = {};
  std::vector<int> accepted = {};  ///< indices of matches; empty: by their ids
  bool of_map = false;             ///< they are the first of a map, which they place

  bool by_appearance() const { return !accepted.empty(); }
};

/// Closes loops (docs/recognition.md): landmarks that leave the state are kept by their ids or
/// their appearance, and return into it where they are recognised. It also finds the place of the
/// run in a map of an earlier one, and knows what a later run can recognise.
/// The steps of a frame are search(), close() and, at its end, note_leaving() and
/// bar_others().
class LoopCloser {
 public:
  /// `prior`: a map in which the run looks for its place, with Recognise::kAppearance.
  LoopCloser(const LoopSettings& settings, std::vector<Camera> cameras,
             std::shared_ptr<const LandmarkMap> prior = nullptr);

  /// Nav is the frame of the prior map, if there is one. `time`: of the start, by the IMU's clock.
  void start_in_map(Ekf& filter, Time time);

  /// The frame's observations, with those of recognised landmarks under their first ids. Valid
  /// until the next call.
  std::span<const PixelObservation> renamed(const FeatureFrame& frame);
  /// The observation of the frame from which renamed() made this one.
  const PixelObservation& original(const FeatureFrame& frame, const PixelObservation& o) const;

  /// Looks for past landmarks in the frame. `observations`: of renamed().
  std::optional<LoopReturn> search(const FeatureFrame& frame,
                                   const std::vector<const PixelObservation*>& observations,
                                   const Ekf& filter, const FrameMoment& at);
  /// The landmarks return into the state, before the update of the frame.
  void close(LoopReturn& found, Ekf& filter, LandmarkRecords& records, const FrameMoment& at);
  /// In a copy made before close(): they do not return, nor later; a proposed place of the map is
  /// given up.
  void leave_out(const LoopReturn& found, Ekf& filter);
  /// What the update of the frame has done to the pose, after a closure by appearance.
  void note_change(const SE3& before, const SE3& after);
  /// Closures of a filter that this one replaces.
  void note_undone(std::span<const Closure> closures);

  /// Whether this point is a past landmark, which returns by its id.
  bool awaits(LandmarkId id) const {
    return settings_.recognise == Recognise::kIds && past_.contains(id);
  }
  /// Landmarks (indices, rising) are about to leave the state. One that the gate has rejected was
  /// no point, or has become another.
  void note_leaving(std::span<const int> leaving, const Ekf& filter, const LandmarkRecords& records,
                    Time now);
  /// After they have left: those that do not return are discarded by the filter.
  void bar_others(Ekf& filter);

  /// Of the last return, and of the last frame: the landmarks that left because the gate had
  /// rejected them too often.
  std::span<const LandmarkId> returned() const { return returned_; }
  std::span<const LandmarkId> rejected() const { return rejected_; }
  /// Landmarks that were recognised by their appearance.
  const std::vector<Closure>& closures() const { return closures_; }
  /// When a search found past landmarks, whether they returned or would have contained too little
  /// information.
  const std::vector<Time>& recognised() const { return recognised_; }
  /// The landmarks of the tracks that were recognised: (id of the track, id of the landmark).
  const std::map<LandmarkId, LandmarkId>& known_as() const { return known_as_; }
  const PlaceCounts& place_counts() const { return placer_.counts(); }
  /// The prior map, once the run has found its place there.
  const std::optional<PlacedMap>& placed() const { return placed_; }
  /// What another run can recognise, with Recognise::kAppearance (saved_map).
  LandmarkMap landmark_map(const Ekf& filter, Time end, std::optional<Time> until) const;

 private:
  std::optional<LoopReturn> search_ids(const std::vector<const PixelObservation*>& observations,
                                       Time now);
  std::optional<LoopReturn> search_images(const FeatureFrame& frame,
                                          const std::vector<const PixelObservation*>& observations,
                                          const Ekf& filter, const FrameMoment& at);
  std::optional<LoopReturn> search_map(const Surroundings& here, Time by_imu);
  std::optional<LoopReturn> search_among(PastLandmarks& past, CompatibleMatches& compatible,
                                         const Surroundings& here, Time by_imu);
  void note_views(const std::vector<ObservedLandmark>& observed);
  void place_map(Ekf& filter, Time by_imu);
  void replace_observed(LoopReturn& found, Ekf& filter, LandmarkRecords& records,
                        const FrameMoment& at);
  bool may_return(const Landmark& landmark, const PastLandmark& past, const Ekf& filter);

  LoopSettings settings_;
  std::vector<Camera> cameras_;
  PastLandmarks past_;
  std::map<LandmarkId, Appearance> appearances_;  ///< of landmarks in the state
  std::map<LandmarkId, LandmarkId> known_as_;     ///< tracks of recognised landmarks
  CompatibleMatches compatible_;
  SpatialChoice choice_;
  Describer describer_;
  MapPlacer placer_;  ///< of the prior map, until the run has found its place in it
  std::optional<PlacedMap> placed_;
  std::optional<Time> searched_;  ///< when landmarks were last looked for
  std::vector<Closure> closures_;
  std::vector<Time> recognised_;
  std::vector<LandmarkId> returned_, rejected_;
  std::vector<PixelObservation> renamed_;
  std::vector<int> not_returning_;  ///< of those that leave, in Ekf::past()
};

}  // namespace chasles
