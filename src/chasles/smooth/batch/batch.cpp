#include <algorithm>
#include <memory>
#include <span>
#include <vector>

#include <chasles/base/processor_time.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/smooth/batch/batch.hpp>
#include <chasles/smooth/batch/batch_covariance_detail.hpp>
#include <chasles/smooth/batch/batch_solve_detail.hpp>
#include <chasles/smooth/batch/batch_terms_detail.hpp>
#include <chasles/smooth/batch/position_check_detail.hpp>
#include <chasles/smooth/terms/residual_walk.hpp>

namespace chasles {
namespace {

using namespace smooth_detail;

// An unobservable direction is an error only where it makes a position uncertain.
void check_well_posed(const InertialBatchResult& result) {
  const std::vector<std::string>& names = result.report.unobservable;
  if (names.empty()) return;
  PositionCheck check;
  for (const Estimate& m : result.estimates) {
    check.add(m.world_T_imu.p, m.covariance.block<3, 3>(3, 3));
  }
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : "; ") + name;
  check.end("neither pixels nor IMU determine " + text + " at the start",
            "move with turns and changing speed past points near enough to show parallax, use two "
            "cameras, or state a better start");
}

ResidualWalk walk_of(const BatchProblem& problem, const BatchGraph& graph) {
  const std::vector<Eigen::VectorXd> residuals = problem.whitened_residuals();
  const auto time_of = [&](const PointView& view) {
    return graph.keyframes[static_cast<std::size_t>(view.keyframe)].time;
  };
  ResidualWalk walk;
  std::size_t first = 0;  // residual of the point
  for (const BatchPoint& point : graph.points) {
    const std::vector<PointView>& views = point.views;
    for (std::size_t a = 0; a < views.size(); ++a) {
      if (views[a].match) continue;
      const std::size_t b = next_view(views, a);
      const std::size_t c = b < views.size() ? next_view(views, b) : b;
      if (c >= views.size()) continue;
      walk.add(residuals[first + a], residuals[first + b], residuals[first + c],
               to_seconds(time_of(views[c]) - time_of(views[a])));
    }
    first += views.size();
  }
  return walk;
}

void widen(double factor, const InertialBatchInput& input, const BatchGraph& graph,
           InertialBatchResult& result) {
  result.report.covariance_factor = factor;
  for (Estimate& e : result.estimates) e.covariance *= factor;
  for (MapLandmark& l : result.landmarks) l.covariance *= factor;
  if (!graph.calibration || factor == 1) return;
  Calibration wide = *result.estimates.back().calibration;
  wide.covariance =
      widened(factor, wide.covariance, graph.calibration->covariance, input.considered);
  for (Estimate& e : result.estimates) e.calibration = wide;
}

}  // namespace

void set_health(std::span<Estimate> estimates, const BatchReport& report) {
  const Health health = fits_the_data(report) ? Health::kOk : Health::kDegraded;
  for (Estimate& e : estimates) e.health = health;
}

bool fits_the_data(const BatchReport& report) {
  return report.converged && !report.stalled && report.cost_per_dof < kMostCostPerDof;
}

InertialBatchResult smooth(const InertialBatchInput& input, const std::string& chart,
                           const BatchSettings& settings, const StopRequest& stop) {
  dense::prepare();
  validate(settings);
  InertialBatchResult result;
  BatchReport& report = result.report;
  const double started = processor_seconds();
  BatchGraph graph = batch_graph(input, settings, report);
  const auto problem = at_minimum(
      graph, settings, report,
      [&](double least_depth) {
        return std::make_unique<BatchProblem>(input, chart, settings, graph, least_depth);
      },
      [&](const std::vector<double>& whitened_norms) {
        return cull(input, whitened_norms, settings, graph, report);
      },
      stop);
  const int dof = 2 * report.observations - (graph.anchored ? 2 : 3) * report.landmarks;
  assess(*problem, dof, settings, report);
  const double solved = processor_seconds();
  report.seconds_solve = solved - started;
  const double factor = settings.covariance_factor ? *settings.covariance_factor
                                                   : walk_of(*problem, graph).covariance_factor();
  if (input.considered.empty()) {
    add_estimates(*problem, input, graph, factor, result, stop);
  } else {
    BatchProblem free(input, chart, settings, graph, kLeastDepth, BatchProblem::Considered::kFree);
    add_estimates(free, input, graph, factor, result, stop);
  }
  report.seconds_covariance = processor_seconds() - solved;
  set_health(result.estimates, report);
  check_well_posed(result);
  widen(factor, input, graph, result);
  result.terms.push_back(
      std::make_shared<const BatchTerms>(terms_of(input, settings, graph, report.final_cost)));
  return result;
}

}  // namespace chasles
