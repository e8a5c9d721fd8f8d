#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include <chasles/loop/landmark_map.hpp>
#include <chasles/loop/merge_maps.hpp>

namespace chasles {

/// Two maps in the frame of the first one, a, and what landmarks that both have determine of them.
/// All errors follow from independent ones y of covariance I: those that each map shares, and those
/// of the place of b; and from the points' own. A match is a point of b (`seen`) and one of a. The
/// maps must outlive it.
class MapFusion {
 public:
  using Match = PlaceInMap::Match;

  /// The heading of the place turns about the mean of the matches.
  MapFusion(const LandmarkMap& a, const LandmarkMap& b, const SE3& a_T_b,
            std::span<const Match> matches);

  /// Of maps in one frame: the place is known. `common` are landmarks of one earlier map, which are
  /// the same for certain.
  MapFusion(const LandmarkMap& a, const LandmarkMap& b, std::span<const Match> common);

  /// The errors y given matches, and the NIS of these.
  struct Posterior {
    Eigen::VectorXd mean;
    Eigen::MatrixXd root;  ///< of the covariance
    double nis = 0;
  };
  Posterior solve(std::span<const Match> matches) const;

  /// Moves the place, where it is linearised, to where the matches say it is.
  void relinearise(std::span<const Match> matches);

  /// Squared innovation of a match, given others, or given all of which it is one.
  double square(const Match& match, const Posterior& given, bool is_one) const;

  /// Where the points of a map lie in the frame of a: the mean, and the sum of the variances.
  struct Whereabouts {
    Eigen::Vector3d p;
    double variance = 0;
    Appearance appearance;
  };
  std::vector<Whereabouts> points_of_a(const Posterior& given) const;
  std::vector<Whereabouts> points_of_b(const Posterior& given) const;

  JoinedMaps joined(std::span<const Match> matches) const;

 private:
  struct Difference {
    Eigen::Vector3d d;     ///< of b's point from a's
    Eigen::MatrixXd H;     ///< by y
    Eigen::Matrix3d V;     ///< covariance of what is their own
    Eigen::Matrix3d gain;  ///< of a's own error
  };
  Difference difference(const Match& match) const;
  void place_b();
  Eigen::Index size() const { return a_.covariance.rank() + placed_b_.shared.cols(); }
  Eigen::MatrixXd rows_a(int point) const;
  Eigen::MatrixXd rows_b(int point) const;
  const Eigen::Vector3d& p_b(int point) const {
    return placed_b_.landmarks[static_cast<std::size_t>(point)].p_world;
  }

  const LandmarkMap& a_;
  const LandmarkMap& b_;
  MapPlace place_;
  PriorMap placed_b_;
  std::vector<bool> common_;  ///< points of b; empty: none
};

}  // namespace chasles
