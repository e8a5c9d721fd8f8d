#include <algorithm>
#include <cmath>
#include <memory>

#include <chasles/error.hpp>
#include <chasles/processor_time.hpp>
#include <chasles/smooth/batch.hpp>
#include <chasles/smooth/batch_covariance_detail.hpp>
#include <chasles/smooth/observability.hpp>

namespace chasles {
namespace {

using namespace smooth_detail;

// When the search has roughly ended: outliers are told from the others.
constexpr double kRough = 1e-3;

void check_left(const BatchGraph& graph, const BatchReport& report) {
  if (!graph.points.empty()) return;
  throw Error(ExitCode::kDiverged,
              "batch estimation ended where no landmark agrees with its pixels: " +
                  std::to_string(report.gated) +
                  " observations are farther than batch.gate from their prediction; expected a "
                  "beginning nearer to the truth, or a pixel_sigma as it is");
}

double way(const BatchResult& result) {
  double length = 0;
  for (std::size_t k = 1; k < result.motions.size(); ++k) {
    length +=
        (result.motions[k].motion.nav_T_imu.p - result.motions[k - 1].motion.nav_T_imu.p).norm();
  }
  return length;
}

// What is unobservable is a fault only where the estimates suffer from it.
void check_well_posed(const BatchResult& result) {
  const std::vector<std::string>& names = result.report.unobservable;
  double variance = 0;
  for (const BatchMotion& m : result.motions) {
    variance = std::max(variance, m.motion.covariance.block<3, 3>(3, 3).trace());
  }
  const double sigma = std::sqrt(variance), limit = 1 + 0.1 * way(result);
  if (names.empty() || sigma <= limit) return;
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : "; ") + name;
  throw InputError("the problem is ill-posed: neither pixels nor IMU tell " + text +
                   " at the start, and a position is uncertain by " + std::to_string(sigma) +
                   " m (expected at most " + std::to_string(limit) +
                   " m): move with turns and changing speed past points near enough to show "
                   "parallax, use two cameras, or state a better start");
}

}  // namespace

BatchResult smooth(const BatchInput& input, const std::string& chart,
                   const BatchSettings& settings) {
  if (settings.landmarks != "inverse-depth" && settings.landmarks != "cartesian") {
    throw UsageError("batch.landmarks: found '" + settings.landmarks +
                     "', expected cartesian or inverse-depth");
  }
  BatchResult result;
  BatchReport& report = result.report;
  const double begun = processor_seconds();
  BatchGraph graph = batch_graph(input, settings, report);
  auto problem = std::make_unique<BatchProblem>(input, chart, settings, graph);
  const bool gated = settings.gate > 0;
  solve(*problem, graph, settings,
        {.steps = settings.max_iterations,
         .tolerance = gated ? std::max(kRough, settings.tolerance) : settings.tolerance},
        report);
  problem->write_to(graph);
  const int steps_left = settings.max_iterations - report.iterations;
  if (gated && steps_left < 1) report.converged = false;
  if (gated && steps_left > 0) {
    if (cull(input, problem->deviations(), settings.gate, graph, report) > 0) {
      check_left(graph, report);
      problem = std::make_unique<BatchProblem>(input, chart, settings, graph);
    }
    solve(*problem, graph, settings, {.steps = steps_left, .tolerance = settings.tolerance},
          report);
    problem->write_to(graph);
  }
  judge(*problem, graph, settings, report);
  const double solved = processor_seconds();
  report.seconds_solve = solved - begun;
  add_estimates(*problem, input, chart, graph, result);
  report.unobservable =
      unobservable_directions(result.motions.front().motion.covariance, graph.start_covariance);
  report.seconds_covariance = processor_seconds() - solved;
  check_well_posed(result);
  return result;
}

}  // namespace chasles
