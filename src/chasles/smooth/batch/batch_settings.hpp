#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <chasles/base/settings.hpp>
#include <chasles/estimate/landmark_form.hpp>

namespace chasles {

enum class BatchLoss { kNone, kHuber, kCauchy };
enum class BatchSolver { kAuto, kSparseSchur, kDenseSchur, kSparseNormal };

template <>
struct Choices<BatchLoss> {
  static constexpr std::array list{Choice{BatchLoss::kNone, "none"},
                                   Choice{BatchLoss::kHuber, "huber"},
                                   Choice{BatchLoss::kCauchy, "cauchy"}};
};

template <>
struct Choices<BatchSolver> {
  static constexpr std::array list{Choice{BatchSolver::kAuto, "auto"},
                                   Choice{BatchSolver::kSparseSchur, "sparse-schur"},
                                   Choice{BatchSolver::kDenseSchur, "dense-schur"},
                                   Choice{BatchSolver::kSparseNormal, "sparse-normal"}};
};

/// "filter", and the names of all error charts.
std::span<const std::string_view> batch_chart_names();

/// All settings of batch estimation. Chart, noise and start come from the filter's settings
/// (InertialSlamSettings). The list below defines files, --set, --help and summary.json.
struct BatchSettings {
  LandmarkForm landmarks = LandmarkForm::kInverseDepth;
  int frames_per_keyframe = 1;
  bool loops = true;
  double inverse_depth_sigma = 10;
  double min_parallax = 0.01;
  BatchLoss loss = BatchLoss::kHuber;
  std::optional<double> loss_width = {};
  std::optional<double> gate = {};
  int max_rejections = 5;
  std::optional<double> covariance_factor = {};
  BatchSolver solver = BatchSolver::kAuto;
  int max_iterations = 100;
  double tolerance = 1e-8;
  std::string chart = "filter";
  double initial_error = 0;
  int seed = 1;
  int window_steps = 2;
  double window_precision = 0.05;

  /// The gate; auto: 5.
  double gate_sigmas() const { return gate.value_or(5); }
};

/// Calls visit(name, value, unit, meaning, limits) for every setting, in order.
template <SettingsOf<BatchSettings> S, typename Visitor>
void for_each_setting(S& s, Visitor&& visit) {
  visit("landmarks", s.landmarks, "choice",
        "form of a landmark: a point of the world, or a ray and an inverse depth in the first "
        "keyframe that observes it",
        limits::kAny);
  visit("frames_per_keyframe", s.frames_per_keyframe, "count",
        "every n-th frame is a keyframe; the others are not used", limits::kPositive);
  visit("loops", s.loops, "bool",
        "a landmark that returns into view is the same one; false: a new one, as in the filter",
        limits::kAny);
  visit("inverse_depth_sigma", s.inverse_depth_sigma, "1/m",
        "prior of an inverse depth: mean 0 with this sigma", limits::kPositive);
  visit("min_parallax", s.min_parallax, "rad",
        "smallest parallax of a landmark; of an anchored one only where the search starts from the "
        "filter's estimates",
        limits::kNonNegative);
  visit("loss", s.loss, "choice", "robust loss of a pixel's residual", limits::kAny);
  visit("loss_width", s.loss_width, "1",
        "threshold of that loss, in standard deviations of a pixel; auto: 2.5, 1 with the "
        "noise of images, or 0.5 where the noise was estimated from stereo tracks (docs/batch.md)",
        limits::kPositive);
  visit("gate", s.gate, "1",
        "pixels with larger residuals, in standard deviations, after the search has roughly "
        "converged are rejected; 0: no gate; auto: 5, or 2 with the noise of images",
        limits::kNonNegative);
  visit("max_rejections", s.max_rejections, "count",
        "a landmark that the gate rejects in so many keyframes in a row is split when its pixels "
        "agree again (visual-inertial batch only)",
        limits::kPositive);
  visit("covariance_factor", s.covariance_factor, "1",
        "factor of the covariances of a visual-inertial batch or window; auto: measured from the "
        "walk of the residuals along the tracks, at least 1; 1 with rendered images "
        "(docs/covariance.md)",
        limits::kPositive);
  visit("solver", s.solver, "choice",
        "linear solver: landmarks first, or the ordering with the least fill (auto, except for few "
        "keyframes)",
        limits::kAny);
  visit("max_iterations", s.max_iterations, "count", "maximum number of Levenberg-Marquardt steps",
        limits::kPositive);
  visit("tolerance", s.tolerance, "1",
        "the search has converged when the next step should lower the cost by less than this "
        "fraction",
        limits::kPositive);
  visit("chart", s.chart, "choice",
        "error chart of the steps; filter: that of the filter's settings",
        limits::one_of(batch_chart_names()));
  visit("initial_error", s.initial_error, "1",
        "error that is added to the initial states, as a fraction: drift [rad], scale, depths "
        "(studies/convergence.md)",
        limits::kNonNegative);
  visit("seed", s.seed, "number", "of that error", limits::kNonNegative);
  visit("window_steps", s.window_steps, "count",
        "maximum number of Gauss-Newton steps of a window per frame", limits::kPositive);
  visit(
      "window_precision", s.window_precision, "1",
      "there are fewer where the window's minimum is predicted to be nearer than this, in standard "
      "deviations; 0: by batch.tolerance alone",
      limits::kNonNegative);
}

/// Throws UsageError with the setting's name ("batch.gate"), its value and the expected one, for a
/// value out of its limits.
void validate(const BatchSettings& settings);

}  // namespace chasles
