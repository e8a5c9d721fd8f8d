#include <algorithm>
#include <memory>
#include <utility>

#include <ceres/manifold.h>

#include <chasles/slam/inertial_calibration.hpp>
#include <chasles/smooth/batch/batch_problem_detail.hpp>
#include <chasles/smooth/batch/batch_solve_detail.hpp>
#include <chasles/smooth/terms/calibrated_costs_detail.hpp>
#include <chasles/smooth/terms/cost_functions_detail.hpp>

namespace chasles::smooth_detail {
namespace {

ceres::CostFunction* known_cost(const PixelTerm& term, ViewForm form) {
  switch (form) {
    case ViewForm::kPoint:
      return new PointCost(term);
    case ViewForm::kAnchored:
      return new AnchoredCost(term);
    case ViewForm::kAnchor:
      return new AnchorCost(term);
  }
  return nullptr;
}

ceres::CostFunction* cost_of(const InertialBatchInput& input, const BatchGraph& graph,
                             const BatchPoint& point, const PointView& view, ViewForm form,
                             double sigma, double least_depth) {
  const Camera& camera = input.cameras[static_cast<std::size_t>(view.camera)];
  const SE3 of_anchor = anchor_T_imu(input, graph, point);
  if (!graph.calibration) {
    return known_cost({.camera = &camera,
                       .cam_T_imu = cam_T_imu_of(input, graph, view),
                       .of_anchor = of_anchor,
                       .pixel = view.pixel,
                       .sigma = sigma,
                       .least_depth = least_depth},
                      form);
  }
  CalibratedTerm term = calibrated_term(input, graph, view, of_anchor, sigma);
  term.least_depth = least_depth;
  return new CalibratedCost(term, form);
}

}  // namespace

BatchProblem::BatchProblem(const InertialBatchInput& input, const std::string& chart,
                           const BatchSettings& settings, const BatchGraph& graph,
                           double least_depth, Considered considered)
    : ProblemBlocks({.keyframes = graph.keyframes.size(),
                     .points = graph.points.size(),
                     .calibration = CalibrationBlocks(graph.calibration)},
                    chart_of(settings, chart)),
      input_(&input) {
  for (std::size_t k = 0; k < sizes().keyframes; ++k) {
    write_state(graph.keyframes[k].state, motion(k), additive(k));
  }
  for (std::size_t i = 0; i < sizes().points; ++i) {
    Eigen::Map<Eigen::Vector3d>{point(i)} = graph.points[i].parameters;
  }
  add_motion(graph);
  if (graph.calibration) add_calibration(input, graph);
  if (considered == Considered::kHeld) hold(input.considered);
  add_views(input, settings, graph, least_depth);
}

void BatchProblem::add_motion(const BatchGraph& graph) {
  const auto add = [&](std::unique_ptr<ceres::CostFunction> cost, std::vector<double*> of) {
    // As their last block, some terms have the IMU's parameters.
    if (cost->parameter_block_sizes().size() > of.size()) {
      of.push_back(calibration(*sizes().calibration.of_imu()));
    }
    ceres().AddResidualBlock(cost.release(), nullptr, of);
  };
  add(start_cost(graph), {motion(0), additive(0)});
  for (std::size_t k = 0; k + 1 < sizes().keyframes; ++k) {
    add(link_cost(graph, graph.links[k]), {motion(k), additive(k), motion(k + 1), additive(k + 1)});
  }
}

void BatchProblem::add_calibration(const InertialBatchInput& input, const BatchGraph& graph) {
  write_calibration(*graph.calibration, calibration());
  std::vector<double*> all;
  for (std::size_t i = 0; i < sizes().calibration.all().size(); ++i) all.push_back(calibration(i));
  ceres().AddResidualBlock(new CalibrationCost(*input.calibration, graph.calibration_whitening),
                           nullptr, all);
}

void BatchProblem::hold(const std::vector<int>& considered) {
  for (std::size_t i = 0; i < sizes().calibration.all().size(); ++i) {
    const auto& block = sizes().calibration.all()[i];
    std::vector<int> held;
    for (const int row : considered) {
      if (row >= block.row && row < block.row + block.errors) held.push_back(row - block.row);
    }
    if (held.empty()) continue;
    if (static_cast<int>(held.size()) == block.errors) {
      ceres().SetParameterBlockConstant(calibration(i));
    } else {
      ceres().SetManifold(calibration(i), new ceres::SubsetManifold(block.errors, held));
    }
  }
}

std::vector<double*> BatchProblem::blocks_of(const PointView& view, ViewForm form, int anchor,
                                             std::size_t i) {
  double* at = motion(static_cast<std::size_t>(view.keyframe));
  std::vector<double*> blocks;
  if (form != ViewForm::kAnchor) blocks.push_back(at);
  if (form == ViewForm::kAnchored) blocks.push_back(motion(static_cast<std::size_t>(anchor)));
  blocks.push_back(point(i));
  for (const std::size_t k : sizes().calibration.of_camera(view.camera)) {
    blocks.push_back(calibration(k));
  }
  return blocks;
}

void BatchProblem::add_views(const InertialBatchInput& input, const BatchSettings& settings,
                             const BatchGraph& graph, double least_depth) {
  ceres::LossFunction* loss = loss_of(settings);
  for (std::size_t i = 0; i < sizes().points; ++i) {
    const BatchPoint& of = graph.points[i];
    const int anchor = of.views.front().keyframe;
    if (graph.anchored) {
      ceres().AddResidualBlock(new InverseDepthCost(settings.inverse_depth_sigma), nullptr,
                               point(i));
    }
    int matches = 0;
    for (const PointView& view : of.views) {
      const ViewForm form = !graph.anchored           ? ViewForm::kPoint
                            : view.keyframe == anchor ? ViewForm::kAnchor
                                                      : ViewForm::kAnchored;
      add_view(cost_of(input, graph, of, view, form, sigma_of(input, view, matches), least_depth),
               loss, blocks_of(view, form, anchor, i));
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
  if (!graph.calibration) return;
  read_calibration(calibration(), *graph.calibration);
  graph.cameras = calibrated(input_->cameras, graph.calibration);
}

}  // namespace chasles::smooth_detail
