#pragma once

#include <optional>
#include <vector>

#include <chasles/check/check_rotation.hpp>
#include <chasles/check/lens_fit.hpp>
#include <chasles/check/lens_guess.hpp>

namespace chasles {

/// One camera's tracks compared with the gyroscope.
struct CameraFit {
  /// With the stated lens. Nothing where the fit finds nothing.
  std::optional<GyroscopeFit> stated = {};
  /// The mistake in the stated lens that explains the tracks; then the rest is with it undone.
  std::optional<LensGuess> mistake = {};
  /// Nothing where the lens is another one and leaves the clock and the rotation open.
  std::optional<GyroscopeFit> gyroscope = {};
  std::optional<LensFit> lens = {};  ///< as fit_lens()
  /// The signs of the gyroscope's axes with which it agrees with images and extrinsics, where the
  /// stated ones are their mirror image; else (1, 1, 1). The rest is with them.
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();

  /// Whether the images rotate as the gyroscope measures, but for a constant scale and rotation:
  /// else clock, rotation and readout are open.
  bool agrees() const;
  Shutter shutter = {};  ///< as stated

  /// Camera time + offset = IMU time [s]: of the first line of a rolling shutter, if one is stated,
  /// else of the middle row. Of a fit that agrees.
  Measured offset() const;
};

/// Fits the tracks of cameras[camera] as fit_gyroscope() and fit_lens(). Where the stated lens
/// leaves a contradiction of scale, rotation, distortion or readout, other signs of the gyroscope's
/// axes, the mistakes of lens_guesses(), other focal lengths, and the lens of fit_lens() are tried.
/// One of them is the explanation if the scales of the rotations then agree, with a clearly smaller
/// standard deviation. Nothing where neither the stated lens nor another one has a fit.
std::optional<CameraFit> fit_camera(const std::vector<FeatureFrame>& frames,
                                    const std::vector<Camera>& cameras, int camera,
                                    const std::vector<StampedRate>& rates);

}  // namespace chasles
