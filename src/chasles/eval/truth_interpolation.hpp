#pragma once

#include <chasles/lie/trajectory.hpp>

namespace chasles {

/// What the interpolation of a truth between its stamps adds to errors, root mean square.
struct InterpolationError {
  double position = 0;  ///< [m]
  double attitude = 0;  ///< [rad]
  double share = 0;     ///< the share of the compared poses that is no stamp of the truth
};

/// By the motion of the estimate: its poses at the stamps of the truth, interpolated back to its
/// own stamps, against what it has there. `gap`: as pose_at().
InterpolationError interpolation_error(const Trajectory& estimate, const Trajectory& truth,
                                       Time gap);

}  // namespace chasles
