#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/estimate/closure.hpp>
#include <chasles/loop/landmark_map.hpp>
#include <chasles/loop/loop_matching.hpp>
#include <chasles/loop/place.hpp>

namespace chasles {

/// What a run observes of its surroundings now.
struct Surroundings {
  const Ekf& filter;
  std::span<const Camera> cameras;
  const std::vector<ObservedLandmark>& observed;
  const PastLandmarks& past;
  Time now{};  ///< on the clock of PastLandmark::left

  Eigen::Vector3d p_nav() const { return nav_T_camera(cameras, filter.state(), 0).p; }
};

/// Looks for the place of a map in nav, until the landmarks of the map have returned there. A place
/// is proposed by appearance alone; with several failures in a row it is given up.
class MapPlacer {
 public:
  /// Without a map there is nothing to do.
  explicit MapPlacer(std::shared_ptr<const LandmarkMap> map = nullptr) : map_(std::move(map)) {}

  bool searching() const { return map_ != nullptr; }
  /// Whether a place is proposed, in which the landmarks of the map may return.
  bool proposed() const { return place_.has_value(); }
  const PlaceCounts& counts() const { return counts_; }
  PastLandmarks& points() { return points_; }  ///< of the map, at the proposed place
  CompatibleMatches& compatible() { return compatible_; }

  /// Proposes a place, if the surroundings resemble one.
  void propose(const Surroundings& here);
  /// The place is known: nav is the frame of the map.
  void propose_nav();
  /// Where places look alike, one of them may stand out by chance among the landmarks of one
  /// moment. Whether the search finds the proposed place once more, by pairs that are accepted.
  bool finds_again(const Surroundings& here, const LoopInnovations& innovations,
                   const std::vector<int>& accepted, const std::vector<LoopCandidate>& candidates);
  /// A search in the proposed place has found no match. What is compatible may still lack the view
  /// from another place.
  void note_failure();
  /// Gives up the proposed place.
  void reject();

  /// All that is known about points of the map, at the proposed place.
  KnownLandmarks known_points(const Ekf& filter,
                              const std::vector<LoopCandidate>& candidates) const;
  /// The accepted matches determine the place: a better point to linearise the map at.
  void refine(const Surroundings& here, double pixel_sigma, const LoopInnovations& innovations,
              const std::vector<int>& accepted, const std::vector<LoopCandidate>& candidates);
  /// The whole map at its place, for the filter.
  PriorMap placed_map() const;
  /// The place is accepted, at this time of the IMU's clock. Returns the map.
  std::shared_ptr<const LandmarkMap> finish(Time time);

 private:
  std::optional<PlaceInMap> search(const Surroundings& here);
  void put_points_in_place();

  std::shared_ptr<const LandmarkMap> map_;
  std::optional<MapPlace> place_;  ///< proposed
  PastLandmarks points_;           ///< at that place; the number is the index in the map
  CompatibleMatches compatible_;
  int failures_ = 0;  ///< searches in a row that found nothing compatible there
  PlaceCounts counts_;
};

}  // namespace chasles
