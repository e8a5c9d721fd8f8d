#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <chasles/camera/pixel_outcome.hpp>

namespace chasles {

/// A point that was followed into a kept image. Numbers are those of the camera's own pixels,
/// whatever the size of the picture.
struct RunFeature {
  PixelOutcome judged;
  int age = 1;                                 ///< frames in which that camera has seen it
  std::optional<Eigen::Vector2d> before = {};  ///< where it was some frames ago [px]
};

/// What one camera saw in a frame that was kept to be looked at, and what became of it.
struct RunImage {
  Time time{};                ///< of the frame, by the cameras' clock
  int camera = 0;             ///< index into the rig
  int width = 0, height = 0;  ///< of the camera [px]
  std::string jpeg;           ///< the picture, perhaps smaller; empty where there is none
  std::vector<RunFeature> features;
};

/// Writes images.csv, features.csv and images/camC_TIME.jpg of a run folder (docs/formats.md), or
/// removes those that are there where there are no images. Throws UsageError if that is not
/// possible.
void write_run_images(const std::vector<RunImage>& images, const std::filesystem::path& folder);

/// Reads them again, nothing where there is no images.csv. Throws InputError with file, line and
/// column.
std::vector<RunImage> read_run_images(const std::filesystem::path& folder);

}  // namespace chasles
