#pragma once

#include <chasles/check/check_report.hpp>
#include <chasles/frontend/frontend_settings.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles::app {

/// Tracks of a recording's images for `chasles check`. They do not depend on the calibration, which
/// they serve to check. The front end tracks each camera separately and without the gyroscope. It
/// tracks points between two cameras in the same way as from one frame to the next.
struct ImageTracks {
  std::vector<FeatureFrame> frames;  ///< a landmark belongs to one camera or one image pair
  std::vector<Fact> facts;
  std::vector<std::string> not_checked;
};

/// Tracks the images of a part of at most `seconds` [s]: the part with the most rotation by the
/// gyroscope, or the first part if there is no IMU. Masks count, and their coverage is a fact.
/// Throws as read_masks().
ImageTracks track_images(const Recording& recording, double seconds,
                         const FrontendSettings& settings);

}  // namespace chasles::app
