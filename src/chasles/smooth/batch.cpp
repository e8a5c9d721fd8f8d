#include <algorithm>
#include <cmath>
#include <memory>

#include <chasles/error.hpp>
#include <chasles/processor_time.hpp>
#include <chasles/smooth/batch.hpp>
#include <chasles/smooth/batch_covariance_detail.hpp>
#include <chasles/smooth/batch_solve_detail.hpp>
#include <chasles/smooth/observability.hpp>

namespace chasles {
namespace {

using namespace smooth_detail;

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
  check_landmark_form(settings);
  BatchResult result;
  BatchReport& report = result.report;
  const double begun = processor_seconds();
  BatchGraph graph = batch_graph(input, settings, report);
  const auto problem = at_minimum(
      graph, settings, report,
      [&] { return std::make_unique<BatchProblem>(input, chart, settings, graph); },
      [&](const std::vector<double>& deviations) {
        return cull(input, deviations, settings.gate, graph, report);
      });
  const int dof = 2 * report.observations - (graph.anchored ? 2 : 3) * report.landmarks;
  judge(*problem, dof, settings, report);
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
