#pragma once

#include <vector>

#include <Eigen/Core>

namespace chasles {

/// The turn of a body between two times a and b, as two sources have it.
struct TwoTurns {
  Eigen::Matrix3d world_R_a, world_R_b;  ///< of a table of poses
  Eigen::Matrix3d a_R_b;                 ///< of another source
};

/// How far the turns of a table of poses are from those of the other source [rad]: the median,
/// without the part that is the same in all turns, which a gyroscope's bias may cause.
struct TurnErrors {
  double as_read = 0;
  double w_first = 0;  ///< if the columns that were read as x, y, z, w are w, x, y, z
};

/// `turns`: all over about the same time, at least one.
TurnErrors turn_errors(const std::vector<TwoTurns>& turns);

}  // namespace chasles
