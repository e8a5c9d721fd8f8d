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

/// Each image of the first camera makes a frame. An image of another camera joins the nearest frame
/// of the cameras before it, within `tolerance`. Others make frames of their own if the camera
/// finds tracks (are_finders()), and are left out if it only matches those of other cameras.
/// `stamps`: the times of each camera, at least one, rising strictly. `finders`: one a camera.
/// `remarks` receives a sentence on each camera that lacks images for some frames, or has images of
/// no frame.
std::vector<PairedFrame> pair_images(const std::vector<std::vector<Time>>& stamps,
                                     const std::vector<bool>& finders, Time tolerance,
                                     std::vector<std::string>& remarks);

}  // namespace chasles
