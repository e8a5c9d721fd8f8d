#include <algorithm>
#include <cmath>

#include <ceres/ordered_groups.h>

#include <chasles/error.hpp>
#include <chasles/smooth/batch_problem_detail.hpp>

namespace chasles::smooth_detail {
namespace {

// Fewer keyframes are solved densely. Of more, the fill of the whole normal matrix is least: along
// a way landmarks go first, before a board that is always in view the keyframes do.
constexpr std::size_t kFewKeyframes = 30;

std::string solver_for(const BatchGraph& graph, const BatchSettings& settings) {
  if (settings.solver != "auto") return settings.solver;
  if (graph.keyframes.size() <= kFewKeyframes) return "dense-schur";
  return "sparse-normal";
}

ceres::LinearSolverType type_of(const std::string& solver) {
  if (solver == "dense-schur") return ceres::DENSE_SCHUR;
  if (solver == "sparse-schur") return ceres::SPARSE_SCHUR;
  if (solver == "sparse-normal") return ceres::SPARSE_NORMAL_CHOLESKY;
  throw UsageError("batch.solver: found '" + solver +
                   "', expected auto, sparse-schur, dense-schur or sparse-normal");
}

ceres::Solver::Options options_for(BatchProblem& problem, const BatchGraph& graph,
                                   const Search& search, const std::string& solver) {
  ceres::Solver::Options options;
  options.linear_solver_type = type_of(solver);
  options.num_threads = 1;
  options.max_num_iterations = search.steps;
  options.function_tolerance = search.tolerance;
  options.parameter_tolerance = 1e-2 * search.tolerance;
  options.gradient_tolerance = 0;  // its size depends on the chart
  options.logging_type = ceres::SILENT;
  if (options.linear_solver_type != ceres::SPARSE_NORMAL_CHOLESKY) {
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (std::size_t i = 0; i < graph.points.size(); ++i) {
      ordering->AddElementToGroup(problem.point(i), 0);
    }
    for (std::size_t k = 0; k < graph.keyframes.size(); ++k) {
      ordering->AddElementToGroup(problem.motion(k), 1);
      ordering->AddElementToGroup(problem.biases(k), 1);
    }
    options.linear_solver_ordering = std::move(ordering);
  }
  return options;
}

}  // namespace

void solve(BatchProblem& problem, const BatchGraph& graph, const BatchSettings& settings,
           const Search& search, BatchReport& report) {
  report.solver = solver_for(graph, settings);
  const ceres::Solver::Options options = options_for(problem, graph, search, report.solver);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem.ceres(), &summary);
  if (report.costs.empty()) report.initial_cost = summary.initial_cost;
  report.iterations += std::max(static_cast<int>(summary.iterations.size()) - 1, 0);
  report.successful += std::max(summary.num_successful_steps - 1, 0);
  report.final_cost = summary.final_cost;
  for (const ceres::IterationSummary& i : summary.iterations) report.costs.push_back(i.cost);
  report.converged = summary.termination_type == ceres::CONVERGENCE;
  report.end = summary.message;
  if (!summary.IsSolutionUsable() || !std::isfinite(summary.final_cost)) {
    throw Error(ExitCode::kDiverged,
                "batch estimation found no finite minimum: " + summary.message);
  }
}

void judge(const BatchProblem& problem, const BatchGraph& graph, const BatchSettings& settings,
           BatchReport& report) {
  const std::vector<double> deviations = problem.deviations();
  report.outliers = static_cast<int>(
      std::ranges::count_if(deviations, [&](double d) { return d > settings.loss_width; }));
  // Links tie as many numbers as a keyframe has; the start ties its own.
  const int dof = 2 * report.observations - (graph.anchored ? 2 : 3) * report.landmarks;
  report.cost_per_dof = 2 * report.final_cost / std::max(dof, 1);
}

}  // namespace chasles::smooth_detail
