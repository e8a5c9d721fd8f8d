#include <chasles/filter/pixel_projection.hpp>
#include <chasles/smooth/batch/batch_problem_detail.hpp>
#include <chasles/smooth/batch/parts_detail.hpp>

namespace chasles::smooth_detail {
namespace {

// The parameters in the camera of the first remaining view; false: the point is behind it, and its
// lens model ends before 90 degrees.
bool hang_on(const InertialBatchInput& input, const BatchGraph& graph, const HomogeneousPoint& at,
             BatchPoint& point) {
  const PointView& first = point.views.front();
  const SE3 cam_T_imu = cam_T_imu_of(input, graph, first);
  const SE3 imu_T_nav =
      graph.keyframes[static_cast<std::size_t>(first.keyframe)].state.world_T_imu.inverse();
  const SE3 cam_T_nav = cam_T_imu * imu_T_nav;
  const Eigen::Vector3d q = cam_T_nav.R * at.p_world + at.w * cam_T_nav.p;
  const Camera& camera = input.cameras[static_cast<std::size_t>(first.camera)];
  if (!(q.z() > 1e-6 * q.norm()) && !sees_beside(camera)) return false;
  point.face = face_towards(q);
  point.parameters = inverse_depth_in(point.face, q, at.w);
  return true;
}

// The position of an anchored point.
HomogeneousPoint place_of(const InertialBatchInput& input, const BatchGraph& graph,
                          const BatchPoint& point) {
  return homogeneous(anchor_of(graph, point), landmark_of(input, graph, point));
}

// Whether the remaining part is still a landmark. A split one is triangulated from its own rays;
// one that only lost views keeps its position, in the camera of its first view.
bool stands(const InertialBatchInput& input, const BatchSettings& settings, const BatchGraph& graph,
            const BatchPoint& whole, bool split, BatchPoint& part) {
  if (part.views.size() < 2) return false;
  constexpr bool kGoodPoses = true;  // the search has roughly converged
  if (split) return place(input, settings, kGoodPoses, graph, part);
  part.face = whole.face;
  const PointView &before = whole.views.front(), &now = part.views.front();
  const bool moved = now.keyframe != before.keyframe || now.camera != before.camera;
  return !moved || !graph.anchored || hang_on(input, graph, place_of(input, graph, whole), part);
}

}  // namespace

int cull(const InertialBatchInput& input, const std::vector<double>& whitened_norms,
         const BatchSettings& settings, BatchGraph& graph, BatchReport& report) {
  for (BatchKeyframe& keyframe : graph.keyframes) keyframe.observations = 0;
  return keep_what_agrees(
      graph.points, whitened_norms, settings.gate_sigmas(), settings.max_rejections, report,
      [&](const BatchPoint& whole, bool split, BatchPoint& part) {
        return stands(input, settings, graph, whole, split, part);
      },
      [&](const PointView& view) {
        ++graph.keyframes[static_cast<std::size_t>(view.keyframe)].observations;
      });
}

}  // namespace chasles::smooth_detail
