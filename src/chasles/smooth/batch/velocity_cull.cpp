#include <chasles/filter/pixel_projection.hpp>
#include <chasles/smooth/batch/parts_detail.hpp>
#include <chasles/smooth/batch/velocity_graph_detail.hpp>

namespace chasles::smooth_detail {
namespace {

// The parameters in the left camera of the first remaining view; false: the point is behind it.
bool hang_on(const StereoRig& rig, const Numbered<VelocityKeyframe>& keyframes,
             const HomogeneousPoint& at, VelocityPoint& point) {
  const auto k = static_cast<std::size_t>(point.views.front().keyframe);
  const SE3 cam0_T_world = rig.cam0_T_imu * keyframes[k].state.world_T_imu.inverse();
  const Eigen::Vector3d q = cam0_T_world.R * at.p_world + at.w * cam0_T_world.p;
  if (!(q.z() > 1e-6 * q.norm())) return false;
  point.parameters = Eigen::Vector3d(q.x(), q.y(), at.w) / q.z();
  return true;
}

// The position of an anchored point.
HomogeneousPoint place_of(const VelocityBatchInput& input, const VelocityGraph& graph,
                          const VelocityPoint& point) {
  const int anchor = point.views.front().keyframe;
  const auto k = static_cast<std::size_t>(anchor);
  const SE3& world_T_imu = graph.timeline.keyframes[k].state.world_T_imu;
  return homogeneous(Clone{.id = anchor, .world_T_imu = world_T_imu},
                     landmark_of(input.rig, point));
}

// Whether the part is still a landmark; moves its anchor to its own first view with a disparity.
bool stands(const VelocityBatchInput& input, const VelocityGraph& graph, const VelocityPoint& whole,
            VelocityPoint& part) {
  if (!initialise_with_disparity(input.rig, input.settings, part) || part.views.size() < 2)
    return false;
  const bool moved = part.views.front().keyframe != whole.views.front().keyframe;
  return !moved || !graph.anchored ||
         hang_on(input.rig, graph.timeline.keyframes, place_of(input, graph, whole), part);
}

}  // namespace

int cull(const VelocityBatchInput& input, const std::vector<double>& whitened_norms, double gate,
         VelocityGraph& graph, BatchReport& report) {
  for (VelocityKeyframe& keyframe : graph.timeline.keyframes) keyframe.used = 0;
  // As the stereo-velocity filter, which keeps a landmark that it rejects: on 15 recordings,
  // splitting changed nothing.
  constexpr int kNeverSplit = 0;
  return keep_what_agrees(
      graph.points, whitened_norms, gate, kNeverSplit, report,
      [&](const VelocityPoint& whole, bool, VelocityPoint& part) {
        return stands(input, graph, whole, part);
      },
      [&](const StereoView& view) {
        ++graph.timeline.keyframes[static_cast<std::size_t>(view.keyframe)].used;
      });
}

}  // namespace chasles::smooth_detail
