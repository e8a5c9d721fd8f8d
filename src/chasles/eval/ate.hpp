#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include <chasles/eval/alignment.hpp>

namespace chasles {

/// Summary of a list of magnitudes; all NaN for an empty list.
struct Statistics {
  std::size_t count = 0;
  double rmse = 0;
  double mean = 0;
  double median = 0;
  double max = 0;
};

Statistics statistics(std::vector<double> magnitudes);

/// Truth minus aligned estimate at one stamp: attitude Log(R R_hat^T) [rad] and position p - p_hat
/// [m], both in the axes of the truth's world.
struct StampedError {
  Time time{};
  Eigen::Vector3d attitude;
  Eigen::Vector3d position;
};

std::vector<StampedError> pose_errors(const MatchedTrajectories& matched,
                                      const WorldAlignment& alignment);

/// Absolute trajectory error (Sturm et al. 2012): the difference between aligned estimate and truth
/// over all matched stamps.
struct AbsoluteError {
  Alignment alignment = Alignment::kNone;
  WorldAlignment transform;  ///< the alignment applied to the estimate
  Statistics position_m;
  Statistics attitude_deg;  ///< with the rotation of the same alignment
};

AbsoluteError absolute_error(const MatchedTrajectories& matched, Alignment alignment);

}  // namespace chasles
