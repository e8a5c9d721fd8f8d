#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <chasles/settings.hpp>
#include <chasles/slam/landmark_form.hpp>

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

/// Everything that can be set about batch estimation; chart, noise and start are the filter's
/// (InertialSlamSettings). The list below feeds files, --set, --help and summary.json.
struct BatchSettings {
  LandmarkForm landmarks = LandmarkForm::kInverseDepth;
  int frames_per_keyframe = 1;
  bool loops = true;
  double inverse_depth_sigma = 10;
  double min_parallax = 0.01;
  BatchLoss loss = BatchLoss::kHuber;
  std::optional<double> loss_width = {};
  double gate = 5;
  int max_rejections = 5;
  BatchSolver solver = BatchSolver::kAuto;
  int max_iterations = 100;
  double tolerance = 1e-8;
  std::string chart = "filter";
  double initial_error = 0;
  int seed = 1;
  int window_steps = 2;
};

/// Calls visit(name, value, unit, meaning, limits) for every setting, in order.
template <SettingsOf<BatchSettings> S, typename Visitor>
void for_each_setting(S& s, Visitor&& visit) {
  visit("landmarks", s.landmarks, "choice",
        "form of a landmark: a point of the world, or a ray and an inverse depth in the first "
        "keyframe that saw it",
        limits::kAny);
  visit("frames_per_keyframe", s.frames_per_keyframe, "count",
        "every n-th frame is a keyframe; the others are not used", limits::kPositive);
  visit("loops", s.loops, "bool",
        "a landmark that comes back into view is the same; false: a new one, as in the filter",
        limits::kAny);
  visit("inverse_depth_sigma", s.inverse_depth_sigma, "1/m",
        "what is known of an inverse depth beforehand: 0 with this deviation", limits::kPositive);
  visit("min_parallax", s.min_parallax, "rad",
        "a landmark needs rays that differ by this angle; an anchored one only where the search "
        "begins at the filter's run",
        limits::kNonNegative);
  visit("loss", s.loss, "choice", "how much a pixel far from its prediction counts", limits::kAny);
  visit("loss_width", s.loss_width, "1",
        "where that begins, in deviations of a pixel; auto: 2.5, or 0.5 where a deviation was "
        "measured from stereo tracks (docs/batch.md)",
        limits::kPositive);
  visit("gate", s.gate, "1",
        "pixels that are farther from their prediction, in deviations, once the search has roughly "
        "ended are left out of the rest of it; 0: none",
        limits::kNonNegative);
  visit("max_rejections", s.max_rejections, "count",
        "a landmark whose pixels that gate leaves out in so many keyframes in a row is another one "
        "when they agree again (batch with an IMU alone)",
        limits::kPositive);
  visit(
      "solver", s.solver, "choice",
      "how the linear system is solved: landmarks first, or whatever fills least (auto, except of "
      "few keyframes)",
      limits::kAny);
  visit("max_iterations", s.max_iterations, "count", "steps of Levenberg and Marquardt at most",
        limits::kPositive);
  visit("tolerance", s.tolerance, "1",
        "it has converged when the cost falls by less than this part", limits::kPositive);
  visit("chart", s.chart, "choice",
        "coordinates of the steps; filter: those of the filter where the search begins",
        limits::one_of(batch_chart_names()));
  visit("initial_error", s.initial_error, "1",
        "what is added to where the search begins, as a part: drift [rad], scale, depths "
        "(docs/convergence.md)",
        limits::kNonNegative);
  visit("seed", s.seed, "number", "of that error", limits::kNonNegative);
  visit("window_steps", s.window_steps, "count",
        "steps of Gauss and Newton that a window takes a frame at most", limits::kPositive);
}

/// Throws UsageError with the setting's name, its value and what is expected: for one out of its
/// limits ("batch.gate").
void validate(const BatchSettings& settings);

}  // namespace chasles
