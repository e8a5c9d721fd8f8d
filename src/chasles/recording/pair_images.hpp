#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <chasles/base/time.hpp>

namespace chasles {

/// The images of a rig at one instant: for each camera the index of its image, or nothing.
struct PairedFrame {
  Time time{};
  std::vector<std::optional<std::size_t>> members;
};

/// Each image of the first camera makes a frame, because tracks belong to that camera. An image of
/// another camera joins the nearest frame, within `tolerance`; others are left out. `stamps`: the
/// times of each camera, at least one, rising strictly. `remarks` receives a sentence on each
/// camera that lacks images for some frames, or has images of no frame.
std::vector<PairedFrame> pair_images(const std::vector<std::vector<Time>>& stamps, Time tolerance,
                                     std::vector<std::string>& remarks);

}  // namespace chasles
