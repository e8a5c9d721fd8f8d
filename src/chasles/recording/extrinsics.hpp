#pragma once

#include <chasles/recording/recording.hpp>

namespace chasles {

/// How well two interpretations of cam0_T_imu explain a recording.
struct ExtrinsicVerdict {
  int steps = 0;          ///< steps between successive frames that were evaluated, all in turns
  double first_cost = 0;  ///< mean cost of a step with the first interpretation [1]
  double second_cost = 0;
  double sigmas = 0;  ///< mean difference first - second, in sigmas; positive favours the second
};

/// Decides which of two interpretations of cam0_T_imu agrees with the data.
///
/// A point is triangulated in one frame, moved by the body velocity over the time step, and
/// projected into the next frame's left image. A wrong lever arm rho shifts the prediction by omega
/// x rho dt, hence only in turns. The noise of the velocity shifts it as well. The cost of a step
/// is therefore minimised over a velocity correction d within the velocity noise, which is measured
/// from the recording:
///   min over d of sum_i c^2 log(1 + |z_i - h_i(u + d)|^2 / c^2) / 2 px^2 + |d / sigma_u|^2 / 2.
///
/// The velocities of the KITTI recordings are up to a sample early. Both the velocity of the step
/// and that of the next step are tried; the one with the lower cost counts. `recording` needs a rig
/// (without cam0_T_imu), one velocity per frame, and observations in order of landmark number.
ExtrinsicVerdict compare_extrinsics(const Recording& recording, const SE3& first,
                                    const SE3& second);

}  // namespace chasles
