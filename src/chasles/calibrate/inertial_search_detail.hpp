#pragma once

#include <cmath>

#include <chasles/calibrate/inertial_start_detail.hpp>

/// The search of a calibration with an IMU. Private to the calibrate folder.
namespace chasles::calibrate_detail {

/// With what the residuals are weighted.
struct InertialWeights {
  double sigma = 1;                         ///< of a corner's u or v, robust [px]
  double correlation = 1;                   ///< factor on its variance (correlation_factor)
  double gyroscope = 1, accelerometer = 1;  ///< factors on the stated noise

  double pixel_sigma() const { return sigma * std::sqrt(correlation); }
};

/// Where the cost is least, with these weights. Counts steps in `iterations`. Throws InputError
/// where the search leaves the lenses, and with `must_converge` where it does not end.
InertialRig least_rig(InertialProblem& problem, InertialRig x, const InertialWeights& weights,
                      bool must_converge, int& iterations);

/// In rounds, each with the noise that the residuals of the one before show. The instants move to
/// the times that the offset states.
InertialRig searched(InertialProblem& problem, const InertialLayout& layout, InertialRig x,
                     InertialWeights& weights, int& iterations);

/// To which piece of independent errors each instant belongs.
std::vector<int> pieces_of(const InertialProblem& problem);

/// Of the rows of the layout. Throws InputError where the motion does not determine them.
Eigen::MatrixXd inertial_covariance(const InertialProblem& problem, const InertialLayout& layout,
                                    const InertialRig& x);

}  // namespace chasles::calibrate_detail
