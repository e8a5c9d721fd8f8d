#pragma once

#include <optional>
#include <vector>

#include <chasles/initialise/dynamic_window.hpp>
#include <chasles/initialise/preintegration.hpp>

namespace chasles {

/// The unknowns of a window's refinement, in nav (z up, origin and heading at keyframe 0).
struct MotionUnknowns {
  std::vector<InertialState> keyframes;  ///< all with the same biases; world_T_imu is nav_T_imu
  Vector6d biases = Vector6d::Zero();    ///< accelerometer [m/s^2], gyroscope [rad/s]
  /// For each track (x/z, y/z, 1/z [1/m]) in the camera of its first view.
  std::vector<Eigen::Vector3d> points;
};

/// The normal equations of a window: 9 unknowns per keyframe (rotation, position, velocity;
/// standard error, nav axes), then 6 for the biases. The three unknowns of each track are
/// eliminated when the system is solved. Position and heading of keyframe 0 are fixed.
struct MotionSystem {
  Eigen::MatrixXd H;
  Eigen::VectorXd b;
  struct Track {
    std::vector<int> keyframes;
    Eigen::MatrixXd H_pose_point;  ///< 6 rows per keyframe (rotation, position), 3 columns
    Eigen::Matrix3d H_point;
    Eigen::Vector3d b_point;
  };
  std::vector<Track> tracks;
  double cost = 0;     ///< half of the squared residuals, with the Huber loss for pixels
  double squares = 0;  ///< squared residuals of the pixels, without loss
};

/// The weights of the equations.
struct MotionWeights {
  std::vector<Matrix9d>
      imu;  ///< W with W^T W the information matrix, in the axes of the earlier keyframe
  Vector6d bias_sigma = Vector6d::Ones();  ///< standard deviations of the prior, mean 0
  double gravity = 0;                      ///< [m/s^2]
  double huber = 3;  ///< threshold for a pixel's residual, in standard deviations
};

/// Residual of a view [standard deviations]; none where the point is behind the camera.
std::optional<Eigen::Vector2d> view_residual(const MotionWindow& window,
                                             const MotionUnknowns& motion, std::size_t track,
                                             const PlaneView& view);

MotionSystem linearise(const MotionWindow& window, const std::vector<Preintegration>& between,
                       const MotionWeights& weights, const MotionUnknowns& motion);

/// Moves each point towards its minimum, the keyframes staying where they are. A step that is
/// linear in inverse depths is wrong where it changes the scale by much. With points that follow,
/// few steps suffice (inner iterations: Ruhe & Wedin 1980).
void optimise_points(const MotionWindow& window, const MotionWeights& weights,
                     MotionUnknowns& motion);

/// The matrix of keyframes and biases with all points eliminated, and its right-hand side. The
/// diagonals of the points are multiplied by 1 + damping. The gauge is fixed.
struct ReducedSystem {
  Eigen::MatrixXd H;
  Eigen::VectorXd b;
};
ReducedSystem eliminate_points(const MotionSystem& system, double damping);

/// The parameterisation of the keyframes.
enum class Shooting {
  kSingle,    ///< exactly as the samples predict: 15 unknowns, keyframe 0 and the biases, move all
              ///< keyframes
  kMultiple,  ///< each keyframe by itself, constrained by the noise of the samples
};

/// The motion after a damped Gauss-Newton step, and the preintegrations at its biases. None where
/// the equations are singular. Single shooting has no stiff directions and therefore converges from
/// far away. It needs a motion that follows the samples exactly, and returns one.
struct MotionStep {
  MotionUnknowns motion;
  std::vector<Preintegration> between;
};
std::optional<MotionStep> take_step(const MotionWindow& window, const MotionSystem& system,
                                    const MotionStep& from, double gravity, Shooting shooting,
                                    double damping);

}  // namespace chasles
