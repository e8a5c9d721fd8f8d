#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>

#include <ceres/iteration_callback.h>
#include <ceres/ordered_groups.h>
#include <ceres/solver.h>

#include <chasles/base/error.hpp>
#include <chasles/smooth/batch/batch_solve_detail.hpp>

extern "C" {
// Defined where the process uses OpenMP.
[[gnu::weak]] int omp_get_max_active_levels();
[[gnu::weak]] void omp_set_max_active_levels(int levels);
}

namespace chasles::smooth_detail {
namespace {

// During its lifetime, calls from this thread create no OpenMP threads. CHOLMOD requests four
// wherever it can, for parts that are too small: they spent up to half of a batch's processor time
// waiting for each other.
class WithoutOpenMp {
 public:
  WithoutOpenMp() {
    if (!omp_get_max_active_levels || !omp_set_max_active_levels) return;
    before_ = omp_get_max_active_levels();
    omp_set_max_active_levels(0);
  }
  ~WithoutOpenMp() {
    if (before_) omp_set_max_active_levels(*before_);
  }
  WithoutOpenMp(const WithoutOpenMp&) = delete;
  WithoutOpenMp& operator=(const WithoutOpenMp&) = delete;

 private:
  std::optional<int> before_;
};

// Fewer keyframes are solved densely. For more, the whole normal matrix with a fill-reducing
// ordering is best: along a path landmarks come first, but for a board that is always in view the
// keyframes do.
constexpr std::size_t kFewKeyframes = 30;

// The loss of a residual in standard deviations.
double loss_at(const ceres::LossFunction* loss, double whitened_norm) {
  const double square = whitened_norm * whitened_norm;
  if (loss == nullptr) return square;
  std::array<double, 3> rho{};
  loss->Evaluate(square, rho.data());
  return rho[0];
}

BatchSolver solver_for(const ProblemBlocks& problem, const BatchSettings& settings) {
  if (settings.solver != BatchSolver::kAuto) return settings.solver;
  return problem.sizes().keyframes <= kFewKeyframes ? BatchSolver::kDenseSchur
                                                    : BatchSolver::kSparseNormal;
}

ceres::LinearSolverType type_of(BatchSolver solver) {
  if (solver == BatchSolver::kDenseSchur) return ceres::DENSE_SCHUR;
  return solver == BatchSolver::kSparseSchur ? ceres::SPARSE_SCHUR : ceres::SPARSE_NORMAL_CHOLESKY;
}

bool is_point(ProblemBlocks& problem, const double* block) {
  return problem.sizes().points > 0 && block >= problem.point(0);
}

ceres::Solver::Options options_for(ProblemBlocks& problem, int steps, double tolerance,
                                   BatchSolver solver) {
  ceres::Solver::Options options;
  options.linear_solver_type = type_of(solver);
  options.num_threads = 1;
  options.max_num_iterations = steps;
  options.function_tolerance = 0;  // Ceres would discard the last step: see StopRule
  options.parameter_tolerance = 1e-2 * tolerance;
  options.gradient_tolerance = 0;  // its size depends on the chart
  options.logging_type = ceres::SILENT;
  const bool points_first = options.linear_solver_type != ceres::SPARSE_NORMAL_CHOLESKY;
  if (points_first) {
    options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  }
  // After a step each landmark is optimised by itself, from the new poses. Otherwise a step that
  // moves a few landmarks behind a camera, because of wrong pixels, makes the cost jump and would
  // fail repeatedly, until the trust region of all others had vanished. Ceres stops these inner
  // iterations once they do not help.
  options.use_inner_iterations = problem.sizes().points > 0;
  options.inner_iteration_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (double* block : problem.blocks()) {
    const bool point = is_point(problem, block);
    if (points_first) options.linear_solver_ordering->AddElementToGroup(block, point ? 0 : 1);
    if (point) options.inner_iteration_ordering->AddElementToGroup(block, 0);
  }
  return options;
}

// Ends a search after a step: on request, or where the next one is expected to lower the cost by
// less than the fraction `tolerance`. Near the minimum each step lowers it by about the same factor
// less.
class StopRule : public ceres::IterationCallback {
 public:
  StopRule(const StopRequest& stop, double tolerance) : stop_(&stop), tolerance_(tolerance) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& step) override {
    if (*stop_ && (*stop_)()) return ceres::SOLVER_ABORT;
    if (step.iteration == 0 || !step.step_is_valid) return ceres::SOLVER_CONTINUE;
    const double now = std::abs(step.cost_change);
    const double factor = step.step_is_successful && last_ > 0 ? std::min(now / last_, 1.0) : 1;
    last_ = step.step_is_successful ? now : 0;
    return now * factor <= tolerance_ * step.cost ? ceres::SOLVER_TERMINATE_SUCCESSFULLY
                                                  : ceres::SOLVER_CONTINUE;
  }

 private:
  const StopRequest* stop_;
  double tolerance_;
  double last_ = 0;  // change of the cost by the step before; 0: it failed, or there is none
};

}  // namespace

void Search::run(ProblemBlocks& problem, double tolerance) {
  BatchReport& report = *report_;
  report.solver = solver_for(problem, *settings_);
  const int steps = std::max(settings_->max_iterations - report.iterations, 0);
  ceres::Solver::Options options = options_for(problem, steps, tolerance, report.solver);
  // Keeps the previous radius: after a restart, uncertain directions would take a dozen steps.
  options.initial_trust_region_radius =
      std::max(options.initial_trust_region_radius, trust_radius_);
  StopRule rule(stop_, tolerance);
  options.callbacks.push_back(&rule);
  ceres::Solver::Summary summary;
  const WithoutOpenMp one_thread;
  ceres::Solve(options, &problem.ceres(), &summary);
  if (summary.termination_type == ceres::USER_FAILURE) throw BatchStopped();
  if (!summary.iterations.empty()) trust_radius_ = summary.iterations.back().trust_region_radius;
  if (report.costs.empty()) report.initial_cost = summary.initial_cost;
  report.iterations += std::max(static_cast<int>(summary.iterations.size()) - 1, 0);
  report.successful += std::max(summary.num_successful_steps - 1, 0);
  report.final_cost = summary.final_cost;
  for (const ceres::IterationSummary& i : summary.iterations) report.costs.push_back(i.cost);
  const bool by_rule = summary.termination_type == ceres::USER_SUCCESS;
  report.converged = by_rule || summary.termination_type == ceres::CONVERGENCE;
  report.end = by_rule ? "the next step is expected to lower the cost by less than the tolerance"
                       : summary.message;
  if (!summary.IsSolutionUsable() || !std::isfinite(summary.final_cost)) {
    throw Error(ExitCode::kDiverged,
                "batch estimation found no finite minimum: " + summary.message);
  }
}

const std::string& chart_of(const BatchSettings& settings, const std::string& of_filter) {
  return settings.chart == "filter" ? of_filter : settings.chart;
}

void check_left(std::size_t points, const BatchReport& report) {
  if (points > 0) return;
  throw Error(ExitCode::kDiverged,
              "batch estimation ended where no landmark agrees with its pixels: " +
                  std::to_string(report.gated) +
                  " observations are farther than batch.gate from their prediction; expected an "
                  "initial guess nearer to the truth, or the correct pixel_sigma");
}

void check_determined(const NormalEquations& equations, const ProblemBlocks& problem,
                      const std::vector<LandmarkId>& ids) {
  const Eigen::VectorXd diagonal = equations.lower.diagonal();
  std::vector<LandmarkId> lost;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (!(diagonal.segment<3>(problem.point_row(i)).minCoeff() > 0)) lost.push_back(ids[i]);
  }
  if (lost.empty()) return;
  throw Error(
      ExitCode::kDiverged,
      "batch estimation ended where no pixel of landmark " + std::to_string(lost.front()) +
          " constrains its position (the same holds for " + std::to_string(lost.size()) + " of " +
          std::to_string(ids.size()) +
          " landmarks): it is behind the cameras that observed it, or beyond their lens models; "
          "expected an initial guess nearer to the truth (batch.gate above 0 rejects such pixels)");
}

void assess(const ProblemBlocks& problem, int dof, const BatchSettings& settings,
            BatchReport& report) {
  const std::vector<double> whitened_norms = problem.whitened_norms();
  report.loss_width = loss_width_of(settings);
  report.outliers = static_cast<int>(
      std::ranges::count_if(whitened_norms, [](double d) { return d > kLossWidth; }));
  // With the usual width: with a narrow one the cost of anything is small.
  const std::unique_ptr<ceres::LossFunction> used(loss_of(settings));
  const std::unique_ptr<ceres::LossFunction> usual(loss_of(settings, kLossWidth));
  double squares = 2 * report.final_cost;
  for (const double d : whitened_norms) squares += loss_at(usual.get(), d) - loss_at(used.get(), d);
  report.cost_per_dof = squares / std::max(dof, 1);
}

void assess_end(double squared_distance, BatchReport& report) {
  // A cost of zero, for data without noise, cannot be lowered.
  report.decrease_left = report.final_cost > 0 ? squared_distance / (2 * report.final_cost) : 0;
  report.converged = report.converged || report.decrease_left < kAtMinimum;
  report.stalled = report.converged && report.decrease_left > kRough;
}

}  // namespace chasles::smooth_detail
