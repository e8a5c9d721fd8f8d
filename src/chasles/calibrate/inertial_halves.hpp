#pragma once

#include <vector>

#include <chasles/calibrate/inertial_calibration.hpp>

namespace chasles {

/// What two halves of the views and their samples say, each without the other. The halves are
/// alternate pieces of the recordings, of a tenth of their time, but of 3 s at least.
struct InertialHalves {
  /// Of each row of the layout: the second half minus the first, and its standard deviation.
  Eigen::VectorXd difference, sigma;
  /// Of each camera over its image: root mean square of the projections' difference, and of its
  /// standard deviation [px].
  std::vector<double> pixels, pixels_sigma;
};

/// Searches from the result of both with its weights, which takes few steps. Throws InputError
/// where the recordings are too short, or a half does not determine the parameters.
InertialHalves compare_halves(const InertialCalibrationInput& input,
                              const InertialCalibration& calibration);

}  // namespace chasles
