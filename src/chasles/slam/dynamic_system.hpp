#pragma once

#include <optional>
#include <vector>

#include <chasles/slam/dynamic_window.hpp>
#include <chasles/slam/preintegration.hpp>

namespace chasles {

/// What the refinement of a window estimates, in nav (z up, origin and heading at keyframe 0).
struct WindowMotion {
  std::vector<InertialState> keyframes;  ///< all with the same biases
  Vector6d biases = Vector6d::Zero();    ///< accelerometer, gyroscope
  /// Of each track (x/z, y/z, 1/z) in the camera of its first view, there [1/m].
  std::vector<Eigen::Vector3d> points;
};

/// The normal equations of a window: 9 unknowns a keyframe (rotation, position, velocity; standard
/// error, nav axes), then the biases; and three a track, which are eliminated when it is solved.
/// Keyframe 0 keeps its position and its heading.
struct MotionSystem {
  Eigen::MatrixXd H;
  Eigen::VectorXd b;
  struct Track {
    std::vector<int> keyframes;
    Eigen::MatrixXd H_pose_point;  ///< 6 rows a keyframe (rotation, position), 3 columns
    Eigen::Matrix3d H_point;
    Eigen::Vector3d b_point;
  };
  std::vector<Track> tracks;
  double cost = 0;     ///< half of the squared residuals, those of pixels by Huber
  double squares = 0;  ///< squared residuals of the pixels, plain
};

/// What the equations weigh with.
struct MotionWeights {
  std::vector<Matrix9d> imu;  ///< W with W^T W the information, in the axes of the earlier keyframe
  Vector6d bias_sigma = Vector6d::Ones();  ///< prior, about 0
  double gravity = 0;                      ///< [m/s^2]
  double huber = 3;                        ///< a pixel's residual, in standard deviations
};

/// Residual of a view [standard deviations]; none where the point is behind the camera.
std::optional<Eigen::Vector2d> view_residual(const MotionWindow& window, const WindowMotion& motion,
                                             std::size_t track, const PlaneView& view);

MotionSystem linearise(const MotionWindow& window, const std::vector<Preintegration>& between,
                       const MotionWeights& weights, const WindowMotion& motion);

/// The matrix of keyframes and biases with all points eliminated, and its right side; the points'
/// diagonals are larger by 1 + damping. The gauge is held.
struct ReducedSystem {
  Eigen::MatrixXd H;
  Eigen::VectorXd b;
};
ReducedSystem eliminate_points(const MotionSystem& system, double damping);

/// How keyframes may move.
enum class Shooting {
  kSingle,    ///< as the samples say exactly: 15 unknowns, keyframe 0 and the biases, move them all
  kMultiple,  ///< each by itself; the samples' noise says how far
};

/// The motion after a damped Gauss-Newton step, and the preintegrations at its biases; none where
/// the equations are singular. Single shooting has no stiff directions and so converges from afar;
/// it needs a motion that follows the samples exactly, and gives one.
struct MotionStep {
  WindowMotion motion;
  std::vector<Preintegration> between;
};
std::optional<MotionStep> take_step(const MotionWindow& window, const MotionSystem& system,
                                    const MotionStep& from, double gravity, Shooting shooting,
                                    double damping);

}  // namespace chasles
