#include <algorithm>
#include <cmath>

#include <Eigen/SparseCore>
#include <ceres/loss_function.h>

#include <chasles/error.hpp>
#include <chasles/smooth/batch_problem_detail.hpp>
#include <chasles/smooth/cost_functions_detail.hpp>

namespace chasles::smooth_detail {
namespace {

ceres::LossFunction* loss_of(const BatchSettings& settings) {
  if (settings.loss == "none") return nullptr;
  if (!(settings.loss_width > 0)) {
    throw UsageError("batch.loss_width: found " + std::to_string(settings.loss_width) +
                     ", expected a number of deviations above 0");
  }
  if (settings.loss == "huber") return new ceres::HuberLoss(settings.loss_width);
  if (settings.loss == "cauchy") return new ceres::CauchyLoss(settings.loss_width);
  throw UsageError("batch.loss: found '" + settings.loss + "', expected none, huber or cauchy");
}

ceres::Problem::Options problem_options() {
  ceres::Problem::Options options;
  options.enable_fast_removal = false;
  return options;
}

}  // namespace

BatchProblem::BatchProblem(const BatchInput& input, const std::string& chart,
                           const BatchSettings& settings, const BatchGraph& graph)
    : keyframes_(graph.keyframes.size()),
      points_(graph.points.size()),
      numbers_(21 * keyframes_ + 3 * points_),
      problem_(std::make_unique<ceres::Problem>(problem_options())) {
  const ErrorChart& coordinates = error_chart(chart);
  for (std::size_t k = 0; k < keyframes_; ++k) {
    const InertialState& state = graph.keyframes[k].state;
    write_motion(state, motion(k));
    Eigen::Map<Vector6d>{biases(k)} = state.biases();
    problem_->AddParameterBlock(motion(k), kMotionNumbers, new ChartManifold(coordinates));
    problem_->AddParameterBlock(biases(k), 6);
  }
  for (std::size_t i = 0; i < points_; ++i) {
    Eigen::Map<Eigen::Vector3d>{point(i)} = graph.points[i].parameters;
    problem_->AddParameterBlock(point(i), 3);
  }
  problem_->AddResidualBlock(new StartCost(graph), nullptr, motion(0), biases(0));
  for (std::size_t k = 0; k + 1 < keyframes_; ++k) {
    problem_->AddResidualBlock(new LinkCost(graph.links[k], graph.gravity), nullptr, motion(k),
                               biases(k), motion(k + 1), biases(k + 1));
  }
  ceres::LossFunction* loss = loss_of(settings);
  for (std::size_t i = 0; i < points_; ++i) {
    const std::vector<PointView>& views = graph.points[i].views;
    const PointView& anchor = views.front();
    if (graph.anchored) {
      problem_->AddResidualBlock(new InverseDepthCost(settings.inverse_depth_sigma), nullptr,
                                 point(i));
    }
    for (const PointView& view : views) {
      const PixelTerm term{.camera = &input.cameras[static_cast<std::size_t>(view.camera)],
                           .anchor_camera = &input.cameras[static_cast<std::size_t>(anchor.camera)],
                           .pixel = view.pixel,
                           .sigma = input.pixel_sigma};
      double* at = motion(static_cast<std::size_t>(view.keyframe));
      if (!graph.anchored) {
        pixels_.push_back(problem_->AddResidualBlock(new PointCost(term), loss, at, point(i)));
      } else if (view.keyframe == anchor.keyframe) {
        pixels_.push_back(problem_->AddResidualBlock(new AnchorCost(term), loss, point(i)));
      } else {
        pixels_.push_back(problem_->AddResidualBlock(
            new AnchoredCost(term), loss, at, motion(static_cast<std::size_t>(anchor.keyframe)),
            point(i)));
      }
    }
  }
}

BatchProblem::~BatchProblem() = default;

std::vector<double*> BatchProblem::blocks() {
  std::vector<double*> all;
  for (std::size_t k = 0; k < keyframes_; ++k) {
    all.push_back(motion(k));
    all.push_back(biases(k));
  }
  for (std::size_t i = 0; i < points_; ++i) all.push_back(point(i));
  return all;
}

void BatchProblem::write_to(BatchGraph& graph) {
  for (std::size_t k = 0; k < keyframes_; ++k) {
    InertialState& state = graph.keyframes[k].state;
    read_motion(motion(k), state);
    state.accelerometer_bias = Eigen::Map<const Eigen::Vector3d>(biases(k));
    state.gyroscope_bias = Eigen::Map<const Eigen::Vector3d>(biases(k) + 3);
  }
  for (std::size_t i = 0; i < points_; ++i) {
    graph.points[i].parameters = Eigen::Map<const Eigen::Vector3d>(point(i));
  }
}

std::vector<double> BatchProblem::deviations() const {
  std::vector<double> all;
  all.reserve(pixels_.size());
  for (const ceres::ResidualBlockId id : pixels_) {
    double cost = 0, residual[2];
    problem_->EvaluateResidualBlockAssumingParametersUnchanged(id, false, &cost, residual, nullptr);
    all.push_back(std::hypot(residual[0], residual[1]));
  }
  return all;
}

Eigen::SparseMatrix<double> normal_matrix(BatchProblem& problem) {
  ceres::Problem::EvaluateOptions options;
  options.parameter_blocks = problem.blocks();
  options.apply_loss_function = true;
  options.num_threads = 1;
  ceres::CRSMatrix crs;
  problem.ceres().Evaluate(options, nullptr, nullptr, nullptr, &crs);
  using RowMajor = Eigen::SparseMatrix<double, Eigen::RowMajor>;
  const Eigen::Map<const RowMajor> J(crs.num_rows, crs.num_cols,
                                     static_cast<Eigen::Index>(crs.values.size()), crs.rows.data(),
                                     crs.cols.data(), crs.values.data());
  const Eigen::SparseMatrix<double> by_columns = J;
  const Eigen::SparseMatrix<double> H = by_columns.transpose() * by_columns;
  return H.triangularView<Eigen::Lower>();
}

}  // namespace chasles::smooth_detail
