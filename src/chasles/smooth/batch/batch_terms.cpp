#include <utility>

#include <chasles/filter/pixel_projection.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/smooth/batch/batch_terms_detail.hpp>
#include <chasles/smooth/batch/problem_blocks_detail.hpp>

namespace chasles::smooth_detail {
namespace {

BatchTerms::Point point_of(const InertialBatchInput& input, const BatchGraph& graph,
                           const BatchPoint& point) {
  BatchTerms::Point result{.id = point.id};
  int matches = 0;
  for (const PointView& view : point.views) {
    result.views.push_back(
        {.keyframe = view.keyframe,
         .camera = view.camera,
         .pixel = view.pixel,
         .sigma = sigma_of(input, view, matches),
         .delay = graph.late(input) +
                  line_delay(graph.cameras[static_cast<std::size_t>(view.camera)], view.pixel)});
  }
  return result;
}

// The prior's mean at the parameters of the IMU: the first state, without those of its errors that
// the parameters do not explain.
InertialState start_of(const BatchGraph& graph) {
  if (graph.start_by_imu.size() == 0) return graph.start;
  InertialState start = graph.keyframes[0].state;
  const Vector15d e = start_error(graph, start) -
                      graph.start_by_imu * (graph.imu()->parameters() - graph.imu_of_start);
  start.world_T_imu.R = so3::exp(-e.head<3>()) * start.world_T_imu.R;
  start.world_T_imu.p -= e.segment<3>(3);
  start.v_world -= e.segment<3>(6);
  start.accelerometer_bias -= e.segment<3>(9);
  start.gyroscope_bias -= e.tail<3>();
  return start;
}

}  // namespace

BatchTerms terms_of(const InertialBatchInput& input, const BatchSettings& settings,
                    const BatchGraph& graph, double cost) {
  BatchTerms terms{.cameras = graph.cameras,
                   .noise = input.noise,
                   .gravity = graph.gravity,
                   .start = start_of(graph),
                   .start_covariance = graph.start_covariance,
                   .loss = settings.loss,
                   .loss_width = loss_width_of(settings),
                   .cost = cost};
  if (graph.anchored) terms.inverse_depth_sigma = settings.inverse_depth_sigma;
  if (graph.calibration) {
    const Eigen::VectorXd whitened = graph.calibration_whitening *
                                     calibration_difference(*graph.calibration, *input.calibration);
    terms.calibration_cost = whitened.squaredNorm() / 2;
  }
  for (const BatchKeyframe& keyframe : graph.keyframes) {
    terms.keyframes.push_back({.time = keyframe.time, .state = keyframe.state});
  }
  const ImuCorrection* imu = graph.imu();
  for (const ImuLink& link : graph.links) {
    terms.between.push_back(imu != nullptr ? corrected(*imu, link).intervals : link.intervals);
  }
  for (const BatchPoint& point : graph.points) {
    HomogeneousPoint at{.p_world = point.parameters, .w = 1};
    if (graph.anchored) {
      at = homogeneous(anchor_of(graph, point), landmark_of(input, graph, point));
      const double whitened = point.parameters.z() / settings.inverse_depth_sigma;
      terms.inverse_depth_cost += whitened * whitened / 2;
    }
    if (!(at.w > 0)) {
      ++terms.beyond_infinity;
      continue;
    }
    terms.points.push_back(point_of(input, graph, point));
    terms.points.back().p_nav = at.p_world / at.w;
  }
  return terms;
}

}  // namespace chasles::smooth_detail
