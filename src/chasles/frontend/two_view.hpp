#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace chasles {

/// One track as two images saw it: unit rays in the axes of the camera then and now.
struct RayPair {
  Eigen::Vector3d last, now;
};

/// What is known before of the motion between the two images.
struct TwoViewPrior {
  Eigen::Matrix3d now_R_last = Eigen::Matrix3d::Identity();  ///< of the camera
  bool trusted = false;     ///< false: the rotation is a guess, and is searched for first
  double threshold = 2e-3;  ///< angle that a right track may be off [rad]
  std::uint64_t seed = 0;   ///< of the samples that are drawn
};

/// The motion that most tracks agree on.
struct TwoView {
  bool decided = false;  ///< false: too few tracks or too little agreement; all count as right
  Eigen::Matrix3d now_R_last = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_now = Eigen::Vector3d::Zero();  ///< p_now = now_R_last p_last + |..| t_now
  std::vector<char> right;                          ///< for each pair
};

/// How far a ray is from where a motion can have put it [rad]: from the half great circle that
/// begins at the rotated ray (a point at infinity) and runs towards t_now (nearer points). What a
/// rotation alone explains is at distance 0 for every t_now; what moves against t_now is not.
double half_circle_distance(const Eigen::Vector3d& rotated_last, const Eigen::Vector3d& now,
                            const Eigen::Vector3d& t_now);

/// Tells right tracks from wrong ones. With the rotation known, two tracks give the direction of
/// the translation: the cross product of their epipolar planes' normals (2-point RANSAC, scored by
/// truncated squares as in Torr & Zisserman's MSAC, CVIU 2000); then rotation and direction are
/// refined together on all tracks, since a gyroscope has a bias, by Gauss-Newton with Cauchy
/// weights. Where less than half agree with a trusted rotation, it is searched for as if there were
/// none.
TwoView find_motion(const std::vector<RayPair>& pairs, const TwoViewPrior& prior);

}  // namespace chasles
