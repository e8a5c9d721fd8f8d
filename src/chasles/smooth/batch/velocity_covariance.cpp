#include <chasles/filter/pixel_projection.hpp>
#include <chasles/lie/small_matrices.hpp>
#include <chasles/smooth/batch/batch_solve_detail.hpp>
#include <chasles/smooth/batch/selected_inverse.hpp>
#include <chasles/smooth/batch/velocity_problem_detail.hpp>

namespace chasles::smooth_detail {
namespace {

// The reference chart's errors by the chart's, of [rotation, position].
Matrix6d to_reference(const VelocityProblem& problem, const VelocityState& state) {
  return inverse(pose_block(problem.chart(), state.world_T_imu));
}

Estimate estimate_of(const VelocityProblem& problem, const SelectedInverse& inverse,
                     const VelocityKeyframe& keyframe, std::size_t k) {
  const Eigen::MatrixXd P = inverse.block(range(problem.keyframe_row(k), problem.sizes().errors()));
  const Matrix6d T = to_reference(problem, keyframe.state);
  Estimate e;
  e.time = keyframe.time;
  e.world_T_imu = keyframe.state.world_T_imu;
  const Matrix6d pose = congruence<6, 6>(T, P.topLeftCorner<6, 6>());
  const auto more = P.cols() - 6;
  e.additive = keyframe.state.additive;
  e.covariance = P;
  e.covariance.topLeftCorner<6, 6>() = (pose + pose.transpose()) / 2;
  e.covariance.topRightCorner(6, more) = T * P.topRightCorner(6, more);
  e.covariance.bottomLeftCorner(more, 6) = e.covariance.topRightCorner(6, more).transpose();
  e.observations = keyframe.offered;
  e.used = keyframe.used;
  return e;
}

// Covariance of an anchored landmark's position, which depends on its anchor's pose.
Eigen::Matrix3d anchored_covariance(const VelocityProblem& problem, const SelectedInverse& inverse,
                                    const VelocityBatchInput& input, const VelocityGraph& graph,
                                    std::size_t i) {
  const VelocityPoint& point = graph.points[i];
  const auto k = static_cast<std::size_t>(point.views.front().keyframe);
  const VelocityState& state = graph.timeline.keyframes[k].state;
  std::vector<int> rows = range(problem.keyframe_row(k), 6);
  for (const int row : range(problem.point_row(i), 3)) rows.push_back(row);
  const Clone anchor{.id = static_cast<int>(k), .world_T_imu = state.world_T_imu};
  Eigen::Matrix<double, 3, 9> J = anchored_derivative(anchor, landmark_of(input.rig, point));
  J.leftCols<6>() = (J.leftCols<6>() * to_reference(problem, state)).eval();
  return congruence<3, 9>(J, inverse.block(rows));
}

}  // namespace

void add_estimates(VelocityProblem& problem, const VelocityBatchInput& input,
                   const VelocityGraph& graph, VelocityBatchResult& result,
                   const StopRequest& stop) {
  const NormalEquations equations = normal_equations(problem);
  check_determined(equations, problem, ids_of(graph.points));
  const SelectedInverse inverse(equations.lower, stop);
  assess_end(equations.gradient.dot(inverse.times(equations.gradient)), result.report);
  const auto& keyframes = graph.timeline.keyframes;
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    if (!keyframes[k].framed) continue;
    result.estimates.push_back(estimate_of(problem, inverse, keyframes[k], k));
    result.estimates.back().landmarks = result.report.landmarks;
  }
  for (std::size_t i = 0; i < graph.points.size(); ++i) {
    const VelocityPoint& point = graph.points[i];
    MapLandmark landmark{.id = point.id, .p_world = point.parameters};
    landmark.observations = static_cast<int>(point.views.size());
    if (graph.anchored) {
      if (!(point.parameters.z() > 0)) continue;  // beyond infinity: a direction without a position
      const int k = point.views.front().keyframe;
      const SE3& world_T_imu = keyframes[static_cast<std::size_t>(k)].state.world_T_imu;
      const HomogeneousPoint at =
          homogeneous(Clone{.id = k, .world_T_imu = world_T_imu}, landmark_of(input.rig, point));
      landmark.p_world = at.p_world / at.w;
      landmark.covariance = anchored_covariance(problem, inverse, input, graph, i);
    } else {
      landmark.covariance = inverse.block(range(problem.point_row(i), 3));
    }
    result.landmarks.push_back(landmark);
  }
}

}  // namespace chasles::smooth_detail
