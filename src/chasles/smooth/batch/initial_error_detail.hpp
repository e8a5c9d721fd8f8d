#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include <chasles/smooth/batch/batch_graph_detail.hpp>
#include <chasles/smooth/batch/velocity_graph_detail.hpp>

/// Where a search begins that begins badly: for this folder's sources alone.
namespace chasles::smooth_detail {

/// Errors of one size, as a poor odometry makes them: they grow along the way, so that the terms
/// between neighbours hardly see them. Errors of every keyframe by itself would be gone after one
/// step, since those terms are stiff and nearly linear. A size of 0.1 is
///
/// 1. an attitude that drifts as a random walk, by 0.1 rad about each axis until the end (one
///    deviation); positions go the way that it steers;
/// 2. a scale: all of the way, and all depths, by one factor exp(0.1 n), n normal;
/// 3. depths: each landmark's by one more factor of that kind.
///
/// The first pose stays where it is. The same seed gives the same errors.
class InitialError {
 public:
  InitialError(double size, std::uint64_t seed) : size_(size), bits_(seed) {}

  /// The poses with 1 and 2; draws anew with every call.
  std::vector<SE3> drifted(const std::vector<SE3>& world_T_imu);
  double scale() const { return scale_; }  ///< of the last way
  double depth_factor();                   ///< 2 and 3, of a landmark

 private:
  double normal();

  double size_ = 0, scale_ = 1;
  std::mt19937_64 bits_;
};

/// Gives the graph's keyframes and landmarks the errors that batch.initial_error says; nothing at
/// 0. Velocities of the world turn and stretch with the way, biases and velocities in the body
/// stay. Landmarks go with the camera of their first look, which sees them as before.
void add_initial_error(const InertialBatchInput& input, const BatchSettings& settings,
                       BatchGraph& graph);
void add_initial_error(const VelocityBatchInput& input, const BatchSettings& settings,
                       VelocityGraph& graph);

}  // namespace chasles::smooth_detail
