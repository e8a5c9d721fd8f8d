#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <chasles/camera/pixel_outcome.hpp>

namespace chasles {

/// A tracked feature in an image. Pixels refer to the camera's resolution, whatever the size of the
/// stored picture.
struct ImageFeature {
  PixelOutcome seen;
  int age = 1;                                 ///< number of frames in which the camera observed it
  std::optional<Eigen::Vector2d> before = {};  ///< pixel some frames ago [px]
};

/// An image for display: its features and their outcomes. Run folders keep some, with pictures.
struct ShownImage {
  Time time{};                ///< of the frame, by the cameras' clock
  int camera = 0;             ///< index into the rig
  int width = 0, height = 0;  ///< of the camera [px]
  std::string jpeg;           ///< the picture, possibly smaller; empty if not stored
  std::vector<ImageFeature> features;
};

/// Writes images.csv, features.csv and images/camC_TIME.jpg of a run folder (docs/formats.md);
/// nothing without images. Throws UsageError if that is not possible.
void write_shown_images(const std::vector<ShownImage>& images, const std::filesystem::path& folder);

/// The pictures in a run folder, as images/camC_TIME.jpg.
std::vector<std::string> pictures_of(const std::filesystem::path& folder);

/// Reads the images of a run folder; empty if there is no images.csv. Throws InputError with file,
/// line and column.
std::vector<ShownImage> read_shown_images(const std::filesystem::path& folder);

}  // namespace chasles
