#include <cmath>
#include <numbers>

#include <chasles/lie/so3.hpp>
#include <chasles/smooth/batch/initial_error_detail.hpp>

namespace chasles::smooth_detail {

// Box-Muller: the distributions of <random> differ between standard libraries, its engines do not.
double InitialError::normal() {
  const auto uniform = [&] { return (static_cast<double>(bits_() >> 11) + 0.5) * 0x1p-53; };
  const double radius = std::sqrt(-2 * std::log(uniform()));
  return radius * std::cos(2 * std::numbers::pi * uniform());
}

std::vector<SE3> InitialError::drifted(const std::vector<SE3>& world_T_imu) {
  scale_ = std::exp(size_ * normal());
  const auto steps = static_cast<double>(world_T_imu.size()) - 1;
  const double sigma = steps > 0 ? size_ / std::sqrt(steps) : 0;
  std::vector<SE3> poses;
  for (std::size_t k = 0; k < world_T_imu.size(); ++k) {
    if (k == 0) {
      poses.push_back(world_T_imu.front());
      continue;
    }
    SE3 step = world_T_imu[k - 1].inverse() * world_T_imu[k];
    const double x = normal(), y = normal(), z = normal();
    step.R = step.R * so3::exp(sigma * Eigen::Vector3d(x, y, z));
    step.p *= scale_;
    poses.push_back(poses.back() * step);
    poses.back().R = so3::normalized(poses.back().R);
  }
  return poses;
}

double InitialError::depth_factor() { return scale_ * std::exp(size_ * normal()); }

namespace {

// The ray of an anchored landmark in its camera is kept, and moves with the camera.
void move(const SE3& cam_T_imu, bool anchored, const SE3& world_T_imu_before,
          const SE3& world_T_imu_after, double factor, Eigen::Vector3d& parameters) {
  if (anchored) {
    parameters.z() /= factor;
    return;
  }
  const Eigen::Vector3d p_cam = cam_T_imu * (world_T_imu_before.inverse() * parameters);
  parameters = world_T_imu_after * (cam_T_imu.inverse() * Eigen::Vector3d(factor * p_cam));
}

// Moves all; `pose_of` and `camera_of` return references.
template <typename Keyframes, typename Points, typename PoseOf, typename CameraOf>
void move_all(const BatchSettings& settings, bool anchored, Keyframes& keyframes, Points& points,
              const PoseOf& pose_of, const CameraOf& cam_T_imu_of, double& scale) {
  InitialError error(settings.initial_error, static_cast<std::uint64_t>(settings.seed));
  std::vector<SE3> before;
  for (auto& keyframe : keyframes) before.push_back(pose_of(keyframe));
  const std::vector<SE3> after = error.drifted(before);
  scale = error.scale();
  for (std::size_t k = 0; k < after.size(); ++k) pose_of(keyframes[k]) = after[k];
  for (auto& point : points) {
    const auto k = static_cast<std::size_t>(point.views.front().keyframe);
    move(cam_T_imu_of(point), anchored, before[k], after[k], error.depth_factor(),
         point.parameters);
  }
}

}  // namespace

void add_initial_error(const InertialBatchInput& input, const BatchSettings& settings,
                       BatchGraph& graph) {
  if (!(settings.initial_error > 0)) return;
  const Numbered<BatchKeyframe> before = graph.keyframes;
  double scale = 1;
  move_all(
      settings, graph.anchored, graph.keyframes, graph.points,
      [](BatchKeyframe& keyframe) -> SE3& { return keyframe.state.world_T_imu; },
      [&](const BatchPoint& point) { return cam_T_imu_of(input, graph, point.views.front()); },
      scale);
  for (std::size_t k = 0; k < before.size(); ++k) {
    InertialState& state = graph.keyframes[k].state;
    state.v_world = scale * (state.world_T_imu.R *
                             (before[k].state.world_T_imu.R.transpose() * before[k].state.v_world));
  }
}

void add_initial_error(const VelocityBatchInput& input, const BatchSettings& settings,
                       VelocityGraph& graph) {
  if (!(settings.initial_error > 0)) return;
  double scale = 1;
  move_all(
      settings, graph.anchored, graph.timeline.keyframes, graph.points,
      [](VelocityKeyframe& keyframe) -> SE3& { return keyframe.state.world_T_imu; },
      [&](const VelocityPoint&) -> const SE3& { return input.rig.cam0_T_imu; }, scale);
}

}  // namespace chasles::smooth_detail
