#include <chasles/filter/pixel_sight.hpp>
#include <chasles/smooth/drive_graph_detail.hpp>

namespace chasles::smooth_detail {
namespace {

// The parameters in the left camera of the first view that is left; false: the point is behind it.
bool hang_on(const StereoRig& rig, const Numbered<DriveKeyframe>& keyframes,
             const HomogeneousPoint& at, DrivePoint& point) {
  const auto k = static_cast<std::size_t>(point.views.front().keyframe);
  const SE3 cam0_T_world = rig.cam0_T_imu * keyframes[k].state.world_T_imu.inverse();
  const Eigen::Vector3d q = cam0_T_world.R * at.p_world + at.w * cam0_T_world.p;
  if (!(q.z() > 1e-6 * q.norm())) return false;
  point.parameters = Eigen::Vector3d(q.x(), q.y(), at.w) / q.z();
  return true;
}

// Keeps the views that agree; false: the landmark goes.
bool keep_views(const DriveInput& input, const std::vector<double>& deviations, double gate,
                const DriveGraph& graph, std::size_t from, DrivePoint& point) {
  const auto& keyframes = graph.timeline.keyframes;
  const int anchor = point.views.front().keyframe;
  const SE3& world_T_imu = keyframes[static_cast<std::size_t>(anchor)].state.world_T_imu;
  const HomogeneousPoint at =
      homogeneous(Clone{.id = anchor, .world_T_imu = world_T_imu}, landmark_of(input.rig, point));
  std::vector<StereoView> views;
  for (std::size_t i = 0; i < point.views.size(); ++i) {
    if (deviations[from + i] <= gate) views.push_back(point.views[i]);
  }
  point.views = std::move(views);
  if (!begin_with_disparity(input.rig, input.settings, point) || point.views.size() < 2) {
    return false;
  }
  const bool moved = point.views.front().keyframe != anchor;
  return !moved || !graph.anchored || hang_on(input.rig, keyframes, at, point);
}

}  // namespace

int cull(const DriveInput& input, const std::vector<double>& deviations, double gate,
         DriveGraph& graph, BatchReport& report) {
  std::size_t from = 0;
  const int before = report.observations;
  std::vector<DrivePoint> kept;
  for (DriveKeyframe& keyframe : graph.timeline.keyframes) keyframe.used = 0;
  report.observations = 0;
  for (DrivePoint& point : graph.points) {
    const std::size_t next = from + point.views.size();
    if (keep_views(input, deviations, gate, graph, from, point)) {
      for (const StereoView& view : point.views) {
        ++graph.timeline.keyframes[static_cast<std::size_t>(view.keyframe)].used;
        ++report.observations;
      }
      kept.push_back(std::move(point));
    } else {
      ++report.landmarks_left_out;
    }
    from = next;
  }
  graph.points = std::move(kept);
  report.landmarks = static_cast<int>(graph.points.size());
  const int gone = before - report.observations;
  report.gated += gone;
  return gone;
}

}  // namespace chasles::smooth_detail
