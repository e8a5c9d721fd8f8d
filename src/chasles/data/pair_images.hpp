#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <chasles/time.hpp>

namespace chasles {

/// The images of a rig at one instant: for each camera the index of its image, or nothing.
struct PairedFrame {
  Time time{};
  std::vector<std::optional<std::size_t>> members;
};

/// Images whose times differ by at most `tolerance` make one frame, at the time of the first camera
/// that has one. `stamps`: the times of each camera, rising strictly. The frames' times rise
/// strictly. `remarks` receives the counts of incomplete frames, and of images that are left out
/// because they lie between the images of another frame.
std::vector<PairedFrame> pair_images(const std::vector<std::vector<Time>>& stamps, Time tolerance,
                                     std::vector<std::string>& remarks);

}  // namespace chasles
