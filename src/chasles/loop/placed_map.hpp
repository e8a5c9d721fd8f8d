#pragma once

#include <memory>
#include <optional>

#include <Eigen/Core>

#include <chasles/estimate/estimate.hpp>
#include <chasles/filter/inertial_model.hpp>
#include <chasles/loop/landmark_map.hpp>

namespace chasles {

/// The map of an earlier run, in which this one has found its place: its frame is a past state of
/// the filter.
class PlacedMap {
 public:
  PlacedMap(std::shared_ptr<const LandmarkMap> map, int number)
      : map_(std::move(map)), number_(number) {}

  const LandmarkMap& map() const { return *map_; }
  int number() const { return number_; }  ///< of its frame in Ekf::past()

  SE3 nav_T_map(const Ekf& filter) const;
  /// The pose in the frame of the map. `derivative`: of the errors of `now` by those of the core
  /// (NavScratch).
  PoseInMap pose_in_map(const Ekf& filter, const NavState& now,
                        const Eigen::MatrixXd& derivative) const;

 private:
  /// The frame, and the derivative of its errors by those that the map shares.
  struct Frame {
    SE3 nav_T_map;
    Eigen::MatrixXd by_shared;
  };
  Frame frame(const Ekf& filter, const Carried& shared) const;

  std::shared_ptr<const LandmarkMap> map_;
  int number_;
};

}  // namespace chasles
