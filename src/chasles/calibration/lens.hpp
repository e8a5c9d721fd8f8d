#pragma once

#include <optional>
#include <string>

#include <chasles/camera/camera.hpp>
#include <chasles/codec/yaml_map.hpp>

namespace chasles {

/// The width or height of an image, from 1 to 100000 px. Throws InputError, starting with `where`,
/// for anything else.
int checked_pixels(const std::string& where, double value);

/// The model of a name of Kalibr, EuRoC, OpenVINS, ROS or OpenCV, in small or capital letters;
/// nothing for another.
std::optional<Distortion> distortion_named(const std::string& name);

/// The names of the distortion keys in a calibration file.
struct LensKeys {
  std::string distortion_model;
  std::string coefficients;
};

/// Size, focal lengths, principal point and distortion of a camera in EuRoC's and Kalibr's
/// notation: keys `resolution`, `intrinsics` and the two of `keys`. The distortion models are none,
/// radtan with four or five coefficients (also radial-tangential, plumb_bob) and equidistant (also
/// equi, fisheye), in small or capital letters. cam_T_imu is not set. Throws InputError for another
/// model, and for a wrong number of coefficients.
Camera read_lens(const YamlMap& map, const LensKeys& keys);

/// The same, with the key `camera_model`, which must be pinhole.
Camera read_pinhole(const YamlMap& map, const LensKeys& keys);

}  // namespace chasles
