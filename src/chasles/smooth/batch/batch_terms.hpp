#pragma once

#include <optional>
#include <vector>

#include <chasles/smooth/batch/batch.hpp>

namespace chasles {

/// The problem of batch estimation and its minimum, for other solvers: the terms of smooth()
/// (docs/batch.md, section 1) after the gate, in nav.
struct BatchTerms {
  /// An observation of a landmark; both numbers count from 0.
  struct View {
    int keyframe = 0, camera = 0;
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
    double sigma = 1;  ///< [px]
    double delay = 0;  ///< of its line after the keyframe [s] (camera/rolling_shutter.hpp)
  };
  struct Point {
    LandmarkId id = 0;  ///< the parts of a split landmark have the same one
    Eigen::Vector3d p_nav = Eigen::Vector3d::Zero();
    std::vector<View> views = {};  ///< by keyframe and camera; the first one is the anchor
  };

  std::vector<Camera> cameras;  ///< as calibrated at the minimum
  ImuNoise noise;
  Eigen::Vector3d gravity = {0, 0, -kStandardGravity};
  /// The prior on the first keyframe: mean, and covariance of [rotation, position, velocity,
  /// accelerometer bias, gyroscope bias], reference chart; with the floors of InertialBatchInput.
  /// The mean is that for the IMU's parameters at the minimum (InertialStart::by_imu).
  InertialState start;
  Matrix15d start_covariance = Matrix15d::Identity();
  std::vector<TimedMotion> keyframes = {};  ///< at the minimum
  /// A keyframe and the next; as corrected at the minimum.
  std::vector<std::vector<ImuInterval>> between = {};
  std::vector<Point> points = {};  ///< at the minimum
  /// Landmarks whose inverse depth is not positive: they have no position, and are not in `points`.
  int beyond_infinity = 0;
  BatchLoss loss = BatchLoss::kHuber;
  double loss_width = 0;  ///< [standard deviations]
  double cost = 0;        ///< BatchReport::final_cost, with all landmarks
  /// Of the inverse depth of every landmark in the camera of its anchor, whose prior has the mean
  /// 0; none for Cartesian landmarks. And the part of the cost that this prior has.
  std::optional<double> inverse_depth_sigma = {};
  double inverse_depth_cost = 0;
  double calibration_cost = 0;  ///< the part of the cost that the prior of the calibration has
};

}  // namespace chasles
