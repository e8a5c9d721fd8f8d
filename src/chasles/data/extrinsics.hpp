#pragma once

#include <chasles/data/recording.hpp>

namespace chasles {

/// How well two readings of cam0_T_imu explain a recording.
struct ExtrinsicVerdict {
  int steps = 0;          ///< steps from one frame to the next, in turns, that were asked
  double first_cost = 0;  ///< mean cost of a step under the first reading [1]
  double second_cost = 0;
  double sigmas = 0;  ///< of the mean difference first - second: positive favours the second
};

/// Which of two readings of cam0_T_imu the data agree with.
///
/// A point is triangulated in a frame, moved by the body velocity over the time step, and projected
/// into the next frame's left image. A wrong lever arm rho shifts the prediction by omega x rho dt,
/// hence in turns only, and so does the noise of the velocity. So the cost of a step is what
/// remains when the velocity may be corrected within its own noise (measured from the recording):
/// min over d of sum_i c^2 log(1 + |z_i - h_i(u + d)|^2 / c^2) / 2 px^2 + |d / sigma_u|^2 / 2.
/// The velocities of the KITTI recordings are up to a sample early; so both the step's own velocity
/// and the next step's are tried, and the one that explains the pixels better counts.
/// `recording` needs rig (without cam0_T_imu), one velocity a frame, and observations in order of
/// landmark number.
ExtrinsicVerdict compare_extrinsics(const Recording& recording, const SE3& first,
                                    const SE3& second);

}  // namespace chasles
