#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include <chasles/smooth/batch/batch_graph_detail.hpp>
#include <chasles/smooth/batch/velocity_graph_detail.hpp>

/// Errors of the initial guess, for convergence studies. Private to this folder.
namespace chasles::smooth_detail {

/// Errors of one size, as from poor odometry. They grow along the path, so that the terms between
/// neighbours hardly contain them. Independent errors of the keyframes would vanish in one step,
/// because those terms are stiff and nearly linear. A size of 0.1 is
///
/// 1. an attitude drift as a random walk, by 0.1 rad about each axis until the end (one sigma),
/// with positions that follow the changed heading;
/// 2. a scale: the whole path, and all depths, times one factor exp(0.1 n), n normal;
/// 3. depths: each landmark's times one more such factor.
///
/// The first pose is not changed. The same seed gives the same errors.
class InitialError {
 public:
  InitialError(double size, std::uint64_t seed) : size_(size), bits_(seed) {}

  /// The poses with errors 1 and 2; every call draws anew.
  std::vector<SE3> drifted(const std::vector<SE3>& world_T_imu);
  double scale() const { return scale_; }  ///< of the last path
  double depth_factor();                   ///< errors 2 and 3 of a landmark

 private:
  double normal();

  double size_ = 0, scale_ = 1;
  std::mt19937_64 bits_;
};

/// Adds the errors of batch.initial_error to the graph's keyframes and landmarks; none at 0.
/// Velocities in the world are rotated and scaled with the path; biases and body velocities are not
/// changed. Landmarks move with the camera of their first observation, so that its pixel is
/// unchanged.
void add_initial_error(const InertialBatchInput& input, const BatchSettings& settings,
                       BatchGraph& graph);
void add_initial_error(const VelocityBatchInput& input, const BatchSettings& settings,
                       VelocityGraph& graph);

}  // namespace chasles::smooth_detail
