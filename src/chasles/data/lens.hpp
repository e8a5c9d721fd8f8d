#pragma once

#include <string>

#include <chasles/camera/camera.hpp>
#include <chasles/data/yaml_map.hpp>

namespace chasles {

/// The width or height of an image, from 1 to 100000 px. Throws InputError, starting with `where`,
/// for anything else.
int checked_pixels(const std::string& where, double value);

/// The names of the distortion keys in a calibration file.
struct LensKeys {
  std::string distortion_model;
  std::string coefficients;
};

/// Size, focal lengths, principal point and distortion of a camera in EuRoC's and Kalibr's
/// notation: keys `resolution`, `camera_model` (pinhole), `intrinsics` and the two of `keys`. The
/// distortion models are radtan (also radial-tangential), equidistant and none. cam_T_imu is not
/// set. Throws InputError for another model, and for a wrong number of coefficients.
Camera read_pinhole(const YamlMap& map, const LensKeys& keys);

}  // namespace chasles
