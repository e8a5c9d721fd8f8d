#pragma once

#include <span>
#include <string>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/codec/yaml_map.hpp>

namespace chasles {

/// The width or height of an image, from 1 to 100000 px. Throws InputError, starting with `where`,
/// for anything else.
int checked_pixels(const std::string& where, double value);

/// Sets the lens model and its coefficients. Throws InputError, starting with `where`, for a number
/// of coefficients that the model does not have, and for values beyond its limits.
void set_lens(const std::string& where, Distortion model, std::span<const double> coefficients,
              Camera& camera);

/// The expected lens models with their names, for the messages of those that are not supported.
std::string expected_lenses();

/// The names of the distortion keys in a calibration file.
struct LensKeys {
  std::string distortion_model;
  std::string coefficients;
};

/// Size, focal lengths, principal point and lens model of a camera in the notation of Chasles: keys
/// `resolution`, `intrinsics` and the two of `keys`, with the models of kLensModels by any of their
/// names. cam_T_imu is not set. Throws InputError for another model, and for a wrong number of
/// coefficients.
Camera read_lens(const YamlMap& map, const LensKeys& keys);

/// The same in the notation of Kalibr and EuRoC: the key `camera_model` is pinhole, or omni, ds or
/// eucm, whose `intrinsics` begin with xi, with xi and alpha, and with alpha and beta. Their
/// distortion model is none; that of omni may be radtan.
Camera read_kalibr_lens(const YamlMap& map, const LensKeys& keys);

/// A lens in Kalibr's notation.
struct KalibrLens {
  std::string camera_model;
  std::vector<double> intrinsics;  ///< those of the camera model, then fx, fy, cx, cy
  std::string distortion_model;
  std::vector<double> coefficients;
};
KalibrLens kalibr_lens(const Camera& camera);

}  // namespace chasles
