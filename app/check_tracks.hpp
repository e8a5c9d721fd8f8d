#pragma once

#include <chasles/check/check_report.hpp>
#include <chasles/data/recording.hpp>

namespace chasles::app {

/// What the front end sees in a recording's images, for `chasles check`: nothing of it rests on the
/// calibration that is to be checked. Each camera is followed by itself, without the gyroscope;
/// between two cameras points are followed as from one instant to the next.
struct ImageTracks {
  std::vector<FeatureFrame> frames;  ///< a landmark is one camera's, or one pair of images'
  std::vector<Fact> facts;
  std::vector<std::string> not_checked;
};

/// Of at most so many seconds, those in which the gyroscope turns most (without one the first).
ImageTracks track_images(const Recording& recording, double seconds);

}  // namespace chasles::app
