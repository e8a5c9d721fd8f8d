#include <chasles/smooth/batch/batch_solve_detail.hpp>
#include <chasles/smooth/batch/velocity_problem_detail.hpp>

namespace chasles::smooth_detail {
namespace {

BlockSizes sizes_of(const VelocityGraph& graph) {
  return {.keyframes = graph.timeline.keyframes.size(),
          .points = graph.points.size(),
          .velocity = false,
          .additive = graph.timeline.model.size()};
}

}  // namespace

VelocityProblem::VelocityProblem(const VelocityBatchInput& input, const BatchSettings& settings,
                                 const VelocityGraph& graph, double least_depth)
    : ProblemBlocks(sizes_of(graph), chart_of(settings, input.settings.chart)),
      least_depth_(least_depth) {
  const VelocityTimeline& timeline = graph.timeline;
  for (std::size_t k = 0; k < sizes().keyframes; ++k) {
    write_pose(timeline.keyframes[k].state.world_T_imu, motion(k));
    std::ranges::copy(timeline.keyframes[k].state.additive, additive(k));
  }
  for (std::size_t i = 0; i < sizes().points; ++i) {
    Eigen::Map<Eigen::Vector3d>{point(i)} = graph.points[i].parameters;
  }
  ceres().AddResidualBlock(new VelocityStartCost(timeline.start), nullptr, keyframe(0));
  for (std::size_t k = 0; k + 1 < sizes().keyframes; ++k) {
    std::vector<double*> both = keyframe(k);
    for (double* block : keyframe(k + 1)) both.push_back(block);
    ceres().AddResidualBlock(new TwistCost(timeline.links[k]), nullptr, both);
  }
  for (const VelocitySample& sample : timeline.samples) {
    const auto k = static_cast<std::size_t>(sample.keyframe);
    ceres().AddResidualBlock(
        new SampleCost(timeline.model, sample), nullptr,
        timeline.model.level ? keyframe(k) : std::vector<double*>{additive(k)});
  }
  add_views(input, settings, graph);
}

void VelocityProblem::add_views(const VelocityBatchInput& input, const BatchSettings& settings,
                                const VelocityGraph& graph) {
  ceres::LossFunction* loss = loss_of(settings);
  for (std::size_t i = 0; i < graph.points.size(); ++i) {
    for (const StereoView& view : graph.points[i].views) {
      const bool first = &view == &graph.points[i].views.front();
      const StereoRows rows = view_rows(input.settings, first);
      const StereoNoise& noise = first ? input.noise.initialisation : input.noise.update;
      if (rows == StereoRows::kMean) {
        add_view_of(stereo_term<2>(input.rig, rows, noise, view.pixels), loss, graph, i, view);
      } else if (rows == StereoRows::kMeanDisparity) {
        add_view_of(stereo_term<3>(input.rig, rows, noise, view.pixels), loss, graph, i, view);
      } else {
        add_view_of(stereo_term<4>(input.rig, rows, noise, view.pixels), loss, graph, i, view);
      }
      rows_ += row_count(rows);
    }
  }
}

template <int Rows>
void VelocityProblem::add_view_of(StereoTerm<Rows> term, ceres::LossFunction* loss,
                                  const VelocityGraph& graph, std::size_t i,
                                  const StereoView& view) {
  term.least_depth = least_depth_;
  double* at = motion(static_cast<std::size_t>(view.keyframe));
  const int anchor = graph.points[i].views.front().keyframe;
  if (!graph.anchored) {
    add_view(new PointCost(term), loss, {at, point(i)});
  } else if (view.keyframe == anchor) {
    add_view(new AnchorCost(term), loss, {point(i)});
  } else {
    add_view(new AnchoredCost(term), loss,
             {at, motion(static_cast<std::size_t>(anchor)), point(i)});
  }
}

void VelocityProblem::write_to(VelocityGraph& graph) {
  for (std::size_t k = 0; k < sizes().keyframes; ++k) {
    VelocityState& state = graph.timeline.keyframes[k].state;
    state.world_T_imu = read_pose(motion(k));
    std::copy_n(additive(k), sizes().additive, state.additive.begin());
  }
  for (std::size_t i = 0; i < sizes().points; ++i) {
    graph.points[i].parameters = Eigen::Map<const Eigen::Vector3d>(point(i));
  }
}

}  // namespace chasles::smooth_detail
