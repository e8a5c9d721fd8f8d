#pragma once

#include <string>
#include <string_view>

#include <chasles/frontend/frontend_settings.hpp>
#include <chasles/initialise/initialiser_settings.hpp>
#include <chasles/slam/inertial_settings.hpp>
#include <chasles/smooth/batch/batch_settings.hpp>
#include <chasles/velocity/velocity_settings.hpp>

namespace chasles {

/// The estimator of a run: filter, batch estimation, or a sliding window of N keyframes.
struct EstimatorChoice {
  enum class Kind { kFilter, kBatch, kWindow };
  Kind kind = Kind::kFilter;
  int keyframes = 0;  ///< of the window

  bool is_filter() const { return kind == Kind::kFilter; }
  bool is_batch() const { return kind == Kind::kBatch; }
  bool is_window() const { return kind == Kind::kWindow; }
};

/// "filter", "batch" or "window:N" with N of 2 or more. Throws UsageError that names `setting`.
EstimatorChoice estimator_choice(std::string_view text, std::string_view setting = "estimator");
/// The other way round.
std::string name_of(const EstimatorChoice& choice);

/// All settings of a visual-inertial run.
struct InertialRunSettings {
  EstimatorChoice estimator = {};
  InertialSlamSettings filter = {};  ///< pixel_sigma: that of the sensors where none is given
  InitialiserSettings start = {};
  FrontendSettings frontend = {};
  BatchSettings batch = {};  ///< for batch and window
};

/// Throws UsageError for a part that cannot be used, and a window of fewer than two keyframes.
void validate(const InertialRunSettings& settings);

/// All settings of a stereo-velocity run.
struct VelocityRunSettings {
  EstimatorChoice estimator = {};
  VelocitySlamSettings filter = {};
  BatchSettings batch = {};  ///< for batch and window
};

/// Throws UsageError for a part that cannot be used, a window of fewer than two keyframes, and,
/// with batch or window, as check_smoothing().
void validate(const VelocityRunSettings& settings);

}  // namespace chasles
