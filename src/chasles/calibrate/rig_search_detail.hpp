#pragma once

#include <string>

#include <chasles/calibrate/levenberg_marquardt.hpp>
#include <chasles/calibrate/rig_problem_detail.hpp>

/// The search of a calibration of cameras. Private to the calibrate folder.
namespace chasles::calibrate_detail {

/// Width of the loss before the noise of the corners is known [px].
constexpr double kFirstLossWidth = 3;

struct Solved {
  RigState state;
  double sigma = 1;    ///< of a pixel
  double squares = 0;  ///< the cost [px^2]
  int iterations = 0;
};

/// Searches with the noise of the corners as the residuals have it. Throws InputError that begins
/// with `of` where there is no minimum.
Solved solved(RigProblem& problem, const CamerasLayout& layout, RigState state,
              const std::string& of, const SearchLimits& limits = {});

}  // namespace chasles::calibrate_detail
