#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <chasles/time.hpp>

namespace chasles {

/// What the cameras of a rig took at one instant: for each the index of its image; none where it
/// has none.
struct PairedFrame {
  Time time{};
  std::vector<std::optional<std::size_t>> members;
};

/// Images whose times differ by at most `tolerance` make one frame, at the time of the first camera
/// that has one. `stamps`: of each camera, rising strictly. The frames' times rise strictly.
/// Remarks count incomplete frames, and images that lie between those of another frame and are left
/// out.
std::vector<PairedFrame> pair_images(const std::vector<std::vector<Time>>& stamps, Time tolerance,
                                     std::vector<std::string>& remarks);

}  // namespace chasles
