#include <chasles/filter/pixel_sight.hpp>
#include <chasles/smooth/batch_problem_detail.hpp>

namespace chasles::smooth_detail {
namespace {

// The parameters in the camera of the first view that is left; false: the point is behind it.
bool hang_on(const BatchInput& input, const BatchGraph& graph, const HomogeneousPoint& at,
             BatchPoint& point) {
  const PointView& first = point.views.front();
  const SE3& cam_T_imu = input.cameras[static_cast<std::size_t>(first.camera)].cam_T_imu;
  const SE3 imu_T_nav =
      graph.keyframes[static_cast<std::size_t>(first.keyframe)].state.world_T_imu.inverse();
  const SE3 cam_T_nav = cam_T_imu * imu_T_nav;
  const Eigen::Vector3d q = cam_T_nav.R * at.p_world + at.w * cam_T_nav.p;
  if (!(q.z() > 1e-6 * q.norm())) return false;
  point.parameters = Eigen::Vector3d(q.x(), q.y(), at.w) / q.z();
  return true;
}

}  // namespace

int cull(const BatchInput& input, const std::vector<double>& deviations, double gate,
         BatchGraph& graph, BatchReport& report) {
  int gone = 0;
  auto deviation = deviations.begin();
  std::vector<BatchPoint> kept;
  for (BatchPoint& point : graph.points) {
    const PointView anchor = point.views.front();
    const HomogeneousPoint at =
        graph.anchored
            ? homogeneous(
                  anchor_of(graph, point),
                  landmark_of(input.cameras[static_cast<std::size_t>(anchor.camera)], point))
            : HomogeneousPoint{.p_world = point.parameters, .w = 1};
    std::vector<PointView> views;
    for (const PointView& view : point.views) {
      if (*deviation++ <= gate) {
        views.push_back(view);
      } else {
        --graph.keyframes[static_cast<std::size_t>(view.keyframe)].observations;
        ++gone;
      }
    }
    const bool moved = views.empty() || views.front().keyframe != anchor.keyframe ||
                       views.front().camera != anchor.camera;
    point.views = std::move(views);
    const bool stays =
        point.views.size() >= 2 && (!graph.anchored || !moved || hang_on(input, graph, at, point));
    if (stays) {
      kept.push_back(std::move(point));
      continue;
    }
    for (const PointView& view : point.views) {
      --graph.keyframes[static_cast<std::size_t>(view.keyframe)].observations;
      ++gone;
    }
    ++report.landmarks_left_out;
  }
  graph.points = std::move(kept);
  report.gated += gone;
  report.observations -= gone;
  report.landmarks = static_cast<int>(graph.points.size());
  return gone;
}

}  // namespace chasles::smooth_detail
