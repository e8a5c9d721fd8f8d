#pragma once

#include <vector>

#include <Eigen/Core>

#include <chasles/calibrate/cameras_calibration.hpp>

namespace chasles {

/// How far a direction may be from the pixel that a calibration gives it.
struct PixelUncertainty {
  Eigen::Vector2d pixel;  ///< at this place of the image
  double sigma_px = 0;    ///< standard deviation along the worse axis [px]
  double sigma_rad = 0;   ///< the same as an angle: times a distance, an error across the ray
};

/// Over a grid of the image, as far as the lens model reaches. A turn of the camera has the effect
/// of other parameters: the turn that does most of it is left out, because whoever uses the camera
/// estimates its attitude. `covariance`: of the lens parameters (fx, fy, cx, cy, coefficients).
std::vector<PixelUncertainty> projection_uncertainty(const Camera& camera,
                                                     const Eigen::MatrixXd& covariance,
                                                     int columns = 17, int rows = 11);

/// The pixels of `other` minus those of `camera` for the directions of a grid of the image, but for
/// the turn that explains most of it [px]. Directions that one of them has no pixel for are left
/// out.
struct PixelDifference {
  Eigen::Vector2d pixel, difference;
};
std::vector<PixelDifference> projection_difference(const Camera& camera, const Camera& other,
                                                   int columns = 17, int rows = 11);

/// Root mean square over the grid, along u and v in the mean [px]; of the uncertainty, along the
/// worse axis. Zero without places.
double rms_of(const std::vector<PixelDifference>& differences);
double rms_of(const std::vector<PixelUncertainty>& grid);

/// The covariance of the lens parameters of one camera.
Eigen::MatrixXd lens_covariance(const CamerasCalibration& calibration, std::size_t camera);

}  // namespace chasles
