#pragma once

#include <cstdint>
#include <vector>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/frontend/frontend_settings.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/run_folder/run.hpp>

namespace chasles {

/// Where an image shows a track.
struct TrackedPixel {
  LandmarkId track = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< in the image, not undistorted [px]
  std::uint8_t camera = 0;                          ///< of the recording
  std::uint8_t grey = 0;                            ///< of that pixel
};

/// The tracks in the images of one instant.
struct TrackedImages {
  Time time{};
  double sharpness = 0;  ///< sharpness(), on average over the images
  std::vector<TrackedPixel> pixels = {};
};

/// The tracks of all images of the recording, as the front end finds them with these settings and
/// the biases of the gyroscope that the run has estimated. The same recording and run give the same
/// tracks. Needs 32 bytes an observation, and no more than a few images at a time. Throws as
/// SensorFeed and read_masks().
std::vector<TrackedImages> track_again(const Recording& recording, const Run& run,
                                       const FrontendSettings& settings);

}  // namespace chasles
