#include <utility>

#include <chasles/lie/small_matrices.hpp>
#include <chasles/smooth/batch/batch_covariance_detail.hpp>
#include <chasles/smooth/batch/batch_solve_detail.hpp>
#include <chasles/smooth/batch/error_covariance_detail.hpp>
#include <chasles/smooth/batch/observability.hpp>
#include <chasles/smooth/terms/chart_manifold_detail.hpp>

namespace chasles::smooth_detail {
namespace {

// The reference chart's errors by the chart's, of [rotation, position, velocity].
Eigen::Matrix<double, 9, 9> to_reference(const ErrorChart& chart, const InertialState& state) {
  State x;
  x.world_T_imu = state.world_T_imu;
  x.v_world = state.v_world;
  return inverse(chart.motion_block(x));
}

// In the reference chart; `P`: of the keyframe's rows.
Matrix15d motion_covariance(const ProblemBlocks& problem, Matrix15d P,
                            const BatchKeyframe& keyframe) {
  const Eigen::Matrix<double, 9, 9> T = to_reference(problem.chart(), keyframe.state);
  P.topRows<9>() = (T * P.topRows<9>()).eval();
  P.leftCols<9>() = (P.leftCols<9>() * T.transpose()).eval();
  return (P + P.transpose()) / 2;
}

MapLandmark anchored_estimate(const ProblemBlocks& problem, const ErrorCovariance& errors,
                              const InertialBatchInput& input, const BatchGraph& graph,
                              std::size_t i) {
  const BatchPoint& point = graph.points[i];
  const PointView& first = point.views.front();
  const auto k = static_cast<std::size_t>(first.keyframe);
  const Landmark landmark = landmark_of(input, graph, point);
  const Clone anchor = anchor_of(graph, point);
  State x;
  x.clones = {anchor};
  MapLandmark result{.id = point.id, .p_world = x.p_world(landmark)};
  // The landmark depends on its anchor's pose, not on its velocity. A landmark that only the anchor
  // observes is not constrained to it in the problem.
  const bool tied = point.views.back().keyframe != first.keyframe;
  std::vector<int> rows = range(problem.keyframe_row(k), 9);
  const std::vector<int> own = range(problem.point_row(i), 3);
  Eigen::Matrix<double, 12, 12> P = Eigen::Matrix<double, 12, 12>::Zero();
  if (tied) {
    rows.insert(rows.end(), own.begin(), own.end());
    P = errors.block(rows);
  } else {
    P.topLeftCorner<9, 9>() = errors.block(rows);
    P.bottomRightCorner<3, 3>() = errors.block(own);
  }
  const Eigen::Matrix<double, 3, 9> d = anchored_derivative(anchor, landmark);
  Eigen::Matrix<double, 3, 12> J;
  J << d.leftCols<6>() * to_reference(problem.chart(), graph.keyframes[k].state).topRows<6>(),
      d.rightCols<3>();
  result.covariance = congruence(J, P);
  return result;
}

ConsideredErrors considered_of(const ProblemBlocks& problem, const InertialBatchInput& input,
                               const BatchGraph& graph, double share) {
  ConsideredErrors considered{.share = share};
  if (input.considered.empty()) return considered;
  for (const int row : input.considered) {
    considered.rows.push_back(problem.calibration_row() + row);
  }
  considered.covariance = graph.calibration->covariance(input.considered, input.considered);
  return considered;
}

}  // namespace

void add_estimates(BatchProblem& problem, const InertialBatchInput& input, const BatchGraph& graph,
                   double factor, InertialBatchResult& result, const StopRequest& stop) {
  NormalEquations equations = normal_equations(problem);
  check_determined(equations, problem, ids_of(graph.points));
  const ErrorCovariance errors(std::move(equations),
                               considered_of(problem, input, graph, 1 / factor), stop);
  assess_end(errors.squared_distance(), result.report);
  // What considered errors add would hide what the measurements determine.
  result.report.unobservable = unobservable_directions(
      motion_covariance(problem, errors.block(range(problem.keyframe_row(0), 15), 0),
                        graph.keyframes[0]),
      graph.start_covariance);
  std::optional<Calibration> calibration = graph.calibration;
  if (calibration) {
    calibration->covariance =
        errors.block(range(problem.calibration_row(), problem.sizes().calibration.errors()), 1);
  }
  for (std::size_t k = 0; k < graph.keyframes.size(); ++k) {
    const BatchKeyframe& keyframe = graph.keyframes[k];
    Estimate& e = result.estimates.emplace_back();
    e.time = keyframe.time;
    e.world_T_imu = keyframe.state.world_T_imu;
    e.v_world = keyframe.state.v_world;
    e.additive = keyframe.state.biases();
    e.covariance =
        motion_covariance(problem, errors.block(range(problem.keyframe_row(k), 15)), keyframe);
    e.calibration = calibration;
    e.observations = e.used = keyframe.observations;
    e.landmarks = result.report.landmarks;
  }
  for (std::size_t i = 0; i < graph.points.size(); ++i) {
    const BatchPoint& point = graph.points[i];
    if (graph.anchored) {
      if (!(point.parameters.z() > 0)) continue;  // beyond infinity: a direction without a position
      result.landmarks.push_back(anchored_estimate(problem, errors, input, graph, i));
    } else {
      result.landmarks.push_back({.id = point.id,
                                  .p_world = point.parameters,
                                  .covariance = errors.block(range(problem.point_row(i), 3))});
    }
    result.landmarks.back().observations = static_cast<int>(point.views.size());
  }
}

}  // namespace chasles::smooth_detail
