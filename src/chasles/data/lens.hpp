#pragma once

#include <string>

#include <chasles/camera/camera.hpp>
#include <chasles/data/yaml_map.hpp>

namespace chasles {

/// A side of an image, from 1 to 100000 px. Throws InputError, which begins with `where`, for
/// anything else.
int checked_pixels(const std::string& where, double value);

/// How a file of calibration names the parts of a pinhole camera.
struct LensKeys {
  std::string distortion_model;
  std::string coefficients;
};

/// Size, focal lengths, principal point and distortion of a camera as EuRoC and Kalibr write them:
/// keys `resolution`, `camera_model` (pinhole), `intrinsics` and the two of `keys`; models radtan
/// (also radial-tangential), equidistant and none. cam_T_imu is left as it is. Throws InputError
/// for another model, and for a number of coefficients that is not the model's.
Camera read_pinhole(const YamlMap& map, const LensKeys& keys);

}  // namespace chasles
