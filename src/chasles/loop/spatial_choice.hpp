#pragma once

#include <array>
#include <map>
#include <set>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/feature_frame.hpp>

namespace chasles {

/// Chooses landmarks so that they cover the space that was seen: one in each cell, for each of six
/// sides that it was seen from. The edge of a cell is a part of the distance from which it was
/// seen.
class SpatialChoice {
 public:
  /// Not more than `most` landmarks.
  explicit SpatialChoice(int most) : most_(most) {}

  /// Chooses the landmark, if nothing else is chosen there: its position, the distance from which
  /// it was seen, and the direction to the camera. Returns whether it is chosen, now or before.
  bool choose(LandmarkId id, const Eigen::Vector3d& p_map, double distance,
              const Eigen::Vector3f& from);
  /// No longer chooses a landmark; another may take its place.
  void give_up(LandmarkId id);
  /// Where there are too many, the cells become larger, and the oldest landmark of each is kept.
  /// Returns the others, which are no longer chosen.
  std::vector<LandmarkId> thin();

  int size() const { return static_cast<int>(chosen_.size()); }

 private:
  using Cell = std::array<int, 5>;
  struct Chosen {
    Eigen::Vector3d p_map;
    double distance = 0;
    int side = 0;
    int order = 0;
  };
  Cell cell(const Chosen& chosen) const;

  int most_;
  double edge_ = 0.1;  ///< as a part of the distance
  int order_ = 0;
  std::map<LandmarkId, Chosen> chosen_;
  std::set<Cell> cells_;
};

}  // namespace chasles
