#pragma once

#include <string>

#include <chasles/smooth/batch/batch_settings.hpp>

namespace chasles::test {

/// Plain least squares to the last digit: no loss, no gate, steps until none lowers the cost.
inline BatchSettings exact_settings(LandmarkForm landmarks) {
  BatchSettings settings;
  settings.landmarks = landmarks;
  settings.loss = BatchLoss::kNone;
  settings.gate = 0;
  settings.covariance_factor = 1;
  settings.tolerance = 1e-15;
  settings.window_precision = 0;
  settings.max_iterations = settings.window_steps = 200;
  return settings;
}

}  // namespace chasles::test
