#pragma once

#include <functional>

#include <chasles/smooth/batch.hpp>
#include <chasles/smooth/problem_blocks_detail.hpp>

/// The search for the minimum, whatever moves: for this folder's sources alone.
namespace chasles::smooth_detail {

/// Searches the minimum from the present numbers, in at most so many steps. Adds its steps to the
/// report; throws Error(kDiverged).
struct Search {
  int steps = 50;
  double tolerance = 1e-8;
};
void solve(ProblemBlocks& problem, const BatchSettings& settings, const Search& search,
           BatchReport& report);

/// The whole search: solves roughly, `cull`s what the gate does not let pass, and solves to the
/// end; without a gate in one go.
void search(const BatchSettings& settings, BatchReport& report,
            const std::function<void(const Search&)>& solve, const std::function<void()>& cull);

/// Throws UsageError where batch.landmarks is none of the forms.
void check_landmark_form(const BatchSettings& settings);

/// The error chart of the steps: batch.chart, or the filter's.
const std::string& chart_of(const BatchSettings& settings, const std::string& of_filter);

/// Throws UsageError for batch.frames_per_keyframe below 1.
void check_frames_per_keyframe(const BatchSettings& settings);

/// Throws Error(kDiverged) where the gate left no landmark.
void check_left(std::size_t points, const BatchReport& report);

/// The problem that `make` makes of the graph, at its minimum, which the graph has as well. `cull`
/// takes out of the graph what deviates too much and says how many; then the problem is made anew.
template <typename Graph, typename Make, typename Cull>
auto at_minimum(Graph& graph, const BatchSettings& settings, BatchReport& report, const Make& make,
                const Cull& cull) {
  auto problem = make();
  search(
      settings, report,
      [&](const Search& steps) {
        solve(*problem, settings, steps, report);
        problem->write_to(graph);
      },
      [&] {
        if (cull(problem->deviations()) == 0) return;
        check_left(graph.points.size(), report);
        problem = make();
      });
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
