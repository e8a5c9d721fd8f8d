#pragma once

#include <algorithm>

#include <chasles/smooth/batch/batch.hpp>
#include <chasles/smooth/batch/problem_blocks_detail.hpp>
#include <chasles/smooth/terms/cost_functions_detail.hpp>

/// The search for the minimum, whatever moves: for this folder's sources alone.
namespace chasles::smooth_detail {

/// What a step gains of the cost when the search is no longer on its way from a bad beginning; and
/// when it has roughly ended, and outliers are told from the others.
inline constexpr double kArrived = 1e-2, kRough = 1e-3;
/// Where a whole step should lower the cost by less than this part of it, that is its minimum.
inline constexpr double kAtMinimum = 1e-7;

/// A search for the minimum, of one problem after the other: in all at most batch.max_iterations
/// steps, which the report counts.
class Search {
 public:
  /// Keeps both references.
  Search(const BatchSettings& settings, BatchReport& report)
      : settings_(&settings), report_(&report) {}
  /// From the present numbers until a step gains less than `tolerance` of the cost. Throws
  /// Error(kDiverged).
  void run(ProblemBlocks& problem, double tolerance);

 private:
  const BatchSettings* settings_;
  BatchReport* report_;
  double trust_radius_ = 0;  ///< how far the last step was trusted
};

/// The error chart of the steps: batch.chart, or the filter's.
const std::string& chart_of(const BatchSettings& settings, const std::string& of_filter);

/// Throws Error(kDiverged) where the gate left no landmark.
void check_left(std::size_t points, const BatchReport& report);

/// The ids of a graph's landmarks.
template <typename Point>
std::vector<LandmarkId> ids_of(const std::vector<Point>& points) {
  std::vector<LandmarkId> ids;
  for (const Point& point : points) ids.push_back(point.id);
  return ids;
}

/// Throws Error(kDiverged) where a landmark ended where none of its pixels tells of it, since no
/// camera sees it there (kNotSeen). `equations`: the problem's normal_equations; `ids`: of all
/// landmarks in the problem's order.
void check_told(const NormalEquations& equations, const ProblemBlocks& problem,
                const std::vector<LandmarkId>& ids);

/// The problem that `make` makes of the graph and a least depth, at its minimum, which the graph
/// has as well. It begins with the least depth for the way, and has the one that holds once it has
/// arrived. Where there is a gate, `cull` takes out of the graph what deviates too much when the
/// search has roughly ended, and says how many.
template <typename Graph, typename Make, typename Cull>
auto at_minimum(Graph& graph, const BatchSettings& settings, BatchReport& report, const Make& make,
                const Cull& cull) {
  auto problem = make(kLeastDepthOnTheWay);
  Search search(settings, report);
  const auto run = [&](double tolerance) {
    search.run(*problem, tolerance);
    problem->write_to(graph);
  };
  run(std::max(kArrived, settings.tolerance));
  problem = make(kLeastDepth);
  if (settings.gate > 0) {
    run(std::max(kRough, settings.tolerance));
    if (report.converged && cull(problem->deviations()) > 0) {
      check_left(graph.points.size(), report);
      problem = make(kLeastDepth);
    }
  }
  run(settings.tolerance);
  return problem;
}

/// What the report says of the fit, at the minimum; `dof`: rows of what was seen less parameters of
/// landmarks. Links tie as many numbers as a keyframe has; the start ties its own.
void judge(const ProblemBlocks& problem, int dof, const BatchSettings& settings,
           BatchReport& report);

/// What the report says of where the search ended: how far from a minimum, g^T H^-1 g of gradient
/// and normal matrix there, and whether it stalled.
void judge_end(double squared_distance, BatchReport& report);

}  // namespace chasles::smooth_detail
