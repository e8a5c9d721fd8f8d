#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace chasles {

/// One track in two images: unit rays in camera axes, then and now.
struct RayPair {
  Eigen::Vector3d last, now;
};

/// Prior on the motion between the two images.
struct TwoViewPrior {
  Eigen::Matrix3d now_R_last = Eigen::Matrix3d::Identity();  ///< of the camera
  bool trusted = false;     ///< false: the rotation is uncertain and is searched for first
  double threshold = 2e-3;  ///< largest angular error of an inlier [rad]
  std::uint64_t seed = 0;   ///< of the random samples
};

/// The motion that is consistent with most tracks.
struct TwoView {
  bool decided = false;  ///< false: too few tracks or inliers; all tracks count as inliers
  Eigen::Matrix3d now_R_last = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_now = Eigen::Vector3d::Zero();  ///< p_now = now_R_last p_last + |..| t_now
  std::vector<char> right;                          ///< for each pair: inlier or not
};

/// Angular distance [rad] of a ray from the rays that a motion allows: the half great circle from
/// the rotated ray (a point at infinity) towards t_now (nearer points). The distance is 0 for every
/// t_now if the rotation alone explains the ray. It is not 0 for a ray that moves against t_now.
double half_circle_distance(const Eigen::Vector3d& rotated_last, const Eigen::Vector3d& now,
                            const Eigen::Vector3d& t_now);

/// Separates inliers from outliers. With a known rotation, two tracks give the direction of the
/// translation: the cross product of the normals of their epipolar planes (2-point RANSAC, scored
/// by truncated squares as in Torr & Zisserman's MSAC, CVIU 2000). Then Gauss-Newton with Cauchy
/// weights refines rotation and direction together on all tracks, since a gyroscope has a bias. If
/// fewer than half of the tracks agree with a trusted rotation, the rotation is searched for as if
/// it were unknown.
TwoView find_motion(const std::vector<RayPair>& pairs, const TwoViewPrior& prior);

}  // namespace chasles
