#include <memory>

#include <chasles/base/processor_time.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/smooth/batch/batch_solve_detail.hpp>
#include <chasles/smooth/batch/position_check_detail.hpp>
#include <chasles/smooth/batch/velocity_problem_detail.hpp>

namespace chasles {
namespace {

using namespace smooth_detail;

void check_well_posed(const VelocityBatchResult& result) {
  PositionCheck check;
  for (const Estimate& e : result.estimates) {
    check.add(e.world_T_imu.p, e.pose_covariance().bottomRightCorner<3, 3>());
  }
  check.end("neither pixels nor velocities determine the motion",
            "state the correct noise of velocities and pixels");
}

}  // namespace

VelocityBatchResult smooth(const VelocityBatchInput& input, const BatchSettings& given,
                           const StopRequest& stop) {
  validate(input.settings);
  validate(given);
  const BatchSettings settings = with_loss_width(given, input.noise);
  dense::prepare();
  VelocityBatchResult result;
  BatchReport& report = result.report;
  const double started = processor_seconds();
  VelocityGraph graph = velocity_graph(input, settings, report);
  const auto problem = at_minimum(
      graph, settings, report,
      [&](double least_depth) {
        return std::make_unique<VelocityProblem>(input, settings, graph, least_depth);
      },
      [&](const std::vector<double>& whitened_norms) {
        return cull(input, whitened_norms, settings.gate_sigmas(), graph, report);
      },
      stop);
  assess(*problem, problem->rows() - 3 * report.landmarks, settings, report);
  const double solved = processor_seconds();
  report.seconds_solve = solved - started;
  add_estimates(*problem, input, graph, result, stop);
  report.seconds_covariance = processor_seconds() - solved;
  set_health(result.estimates, report);
  check_well_posed(result);
  return result;
}

}  // namespace chasles
