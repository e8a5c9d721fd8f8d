#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <chasles/camera/stereo.hpp>

namespace chasles {

/// What calibration.yaml of a recording folder holds (docs/formats.md).
struct Calibration {
  std::string name;
  StereoRig rig;
  std::vector<std::string> remarks;
};

/// Throws InputError with file and line for an unknown, missing, repeated or malformed key.
Calibration read_calibration(const std::filesystem::path& file);
void write_calibration(const Calibration& calibration, const std::filesystem::path& file);

}  // namespace chasles
