#pragma once

#include <optional>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/camera/stereo.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/velocity/stereo_rows.hpp>

namespace chasles {

/// Standard deviations [px].
struct StereoNoise {
  double u = 1, v = 1;   ///< of the rows (uL + uR)/2 and (vL + vR)/2, or of each pixel for kAll
  double disparity = 1;  ///< of uL - uR
};

/// The rows as a linear map of (uL, vL, uR, vR), and their variances [px^2], followed by zeros up
/// to four.
Eigen::Matrix<double, Eigen::Dynamic, 4, 0, 4, 4> rows_of(StereoRows rows);
Eigen::Vector4d variances_of(StereoRows rows, const StereoNoise& noise);

/// The observation of landmark `index` of the state, linearised (reference chart); none if the
/// landmark has no projection from the estimated pose.
std::optional<Measurement> measure_stereo(const StereoRig& rig, StereoRows rows,
                                          const StereoNoise& noise, const State& x, int index,
                                          const StereoObservation& observation);

/// A landmark from its first observation (Du, eq. 17-19), with the exact covariance of the inverse
/// projection (docs/derivations.md, D42 to D44); none if the disparity is not positive.
std::optional<NewLandmark> initialise_landmark(const StereoRig& rig, const StereoNoise& noise,
                                               const State& x,
                                               const StereoObservation& observation);

}  // namespace chasles
