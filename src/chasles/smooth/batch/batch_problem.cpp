#include <chasles/smooth/batch/batch_problem_detail.hpp>
#include <chasles/smooth/batch/batch_solve_detail.hpp>
#include <chasles/smooth/terms/cost_functions_detail.hpp>

namespace chasles::smooth_detail {
BatchProblem::BatchProblem(const InertialBatchInput& input, const std::string& chart,
                           const BatchSettings& settings, const BatchGraph& graph,
                           double least_depth)
    : ProblemBlocks({.keyframes = graph.keyframes.size(), .points = graph.points.size()},
                    chart_of(settings, chart)) {
  for (std::size_t k = 0; k < sizes().keyframes; ++k) {
    write_state(graph.keyframes[k].state, motion(k), additive(k));
  }
  for (std::size_t i = 0; i < sizes().points; ++i) {
    Eigen::Map<Eigen::Vector3d>{point(i)} = graph.points[i].parameters;
  }
  ceres().AddResidualBlock(new StartCost(graph), nullptr, motion(0), additive(0));
  for (std::size_t k = 0; k + 1 < sizes().keyframes; ++k) {
    ceres().AddResidualBlock(new LinkCost(graph.links[k], graph.gravity), nullptr, motion(k),
                             additive(k), motion(k + 1), additive(k + 1));
  }
  ceres::LossFunction* loss = loss_of(settings);
  for (std::size_t i = 0; i < sizes().points; ++i) {
    const std::vector<PointView>& views = graph.points[i].views;
    const PointView& anchor = views.front();
    if (graph.anchored) {
      ceres().AddResidualBlock(new InverseDepthCost(settings.inverse_depth_sigma), nullptr,
                               point(i));
    }
    int matches = 0;
    for (const PointView& view : views) {
      const PixelTerm term{.camera = &input.cameras[static_cast<std::size_t>(view.camera)],
                           .cam_T_imu = cam_T_imu_of(input, graph, view),
                           .of_anchor = anchor_T_imu(input, graph, graph.points[i]),
                           .pixel = view.pixel,
                           .sigma = sigma_of(input, view, matches),
                           .least_depth = least_depth};
      double* at = motion(static_cast<std::size_t>(view.keyframe));
      if (!graph.anchored) {
        add_view(new PointCost(term), loss, {at, point(i)});
      } else if (view.keyframe == anchor.keyframe) {
        add_view(new AnchorCost(term), loss, {point(i)});
      } else {
        add_view(new AnchoredCost(term), loss,
                 {at, motion(static_cast<std::size_t>(anchor.keyframe)), point(i)});
      }
    }
  }
}

void BatchProblem::write_to(BatchGraph& graph) {
  for (std::size_t k = 0; k < sizes().keyframes; ++k) {
    graph.keyframes[k].state = read_state(motion(k), additive(k));
  }
  for (std::size_t i = 0; i < sizes().points; ++i) {
    graph.points[i].parameters = Eigen::Map<const Eigen::Vector3d>(point(i));
  }
}

}  // namespace chasles::smooth_detail
