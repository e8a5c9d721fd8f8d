#pragma once

#include <vector>

#include <chasles/filter/ekf.hpp>

// The operations of a frame on a covariance, independent of its representation
// (square_root_bench.cpp).
namespace chasles::bench {

/// A new clone or landmark, from the errors of the pose: new = d_pose pose + noise.
struct Fresh {
  bool is_clone = false;
  LandmarkId id = 0;       ///< or the clone's
  Eigen::MatrixXd d_pose;  ///< 6 or 3 x 6
  Eigen::MatrixXd noise;   ///< covariance, 6 x 6 or 3 x 3
};

/// In this order: propagate, drop, add, update.
struct FrameStep {
  Prediction prediction;
  std::vector<int> keep = {};  ///< rows of the state before, the core's among them, rising
  std::vector<int> retired = {}, removed = {};  ///< landmarks by index, clones by id
  std::vector<Fresh> fresh = {};                ///< appended in this order
  std::vector<Measurement> used = {};           ///< linearised at `state`, noise sigma^2 I
  State state = {};                             ///< after drop and add
};

/// The frames of a walk of `seconds` through the building, 10 Hz with 50 landmarks and 15 clones in
/// the state: the predictions, rows and linearised pixels of an InertialSlam. The initialisation of
/// a landmark is not accessible from outside. Here it uses one pose and a depth known to 10 %.
struct Walk {
  Eigen::MatrixXd core_covariance;  ///< at the start
  std::vector<FrameStep> frames;
};
Walk record_walk(int cameras, double seconds);

}  // namespace chasles::bench
