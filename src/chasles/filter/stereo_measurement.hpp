#pragma once

#include <optional>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/camera/stereo.hpp>
#include <chasles/filter/ekf.hpp>

namespace chasles {

/// Which of the four pixels a measurement keeps. vL and vR say the same thing, so their mean loses
/// nothing; the disparity may be left out where its error stays the same along a track and would be
/// counted again with every frame.
enum class StereoRows {
  kAll,            ///< (uL, vL, uR, vR), as Du (20) has it
  kMeanDisparity,  ///< ((uL + uR)/2, (vL + vR)/2, uL - uR): independent where the four are
  kMean,           ///< ((uL + uR)/2, (vL + vR)/2)
};

/// Standard deviations [px].
struct StereoNoise {
  double u = 1, v = 1;   ///< of the rows (uL + uR)/2 and (vL + vR)/2, or of each pixel for kAll
  double disparity = 1;  ///< of uL - uR
};

/// The rows as a linear map of (uL, vL, uR, vR), and their variances, as many as there are rows,
/// then zeros [px^2].
Eigen::Matrix<double, Eigen::Dynamic, 4, 0, 4, 4> rows_of(StereoRows rows);
Eigen::Vector4d variances_of(StereoRows rows, const StereoNoise& noise);

/// The observation of landmark `index` of the state, linearised; none where the landmark has no
/// projection from the estimated pose.
std::optional<Measurement> measure_stereo(const StereoRig& rig, StereoRows rows,
                                          const StereoNoise& noise, const State& x, int index,
                                          const StereoObservation& observation);

/// A landmark from its first observation (Du, eq. 17-19), with the exact covariance of inverse
/// projection (docs/derivations.md, D42 to D44); none where the disparity is not positive.
std::optional<NewLandmark> begin_landmark(const StereoRig& rig, const StereoNoise& noise,
                                          const State& x, const StereoObservation& observation);

}  // namespace chasles
