#pragma once

#include <memory>
#include <string>
#include <vector>

#include <chasles/bags/bag_contents.hpp>
#include <chasles/camera/camera.hpp>
#include <chasles/codec/image_source.hpp>

namespace chasles {

/// The images of a rig in a bag, read on request; they are put in order of time and paired, with
/// remarks. `topics`: one for each camera of the rig. `offsets`: of each camera, added to its
/// stamps; empty: none. Throws InputError if the first image of a topic has another size than the
/// calibration, or an encoding that is not known.
std::shared_ptr<const ImageSource> open_bag_images(
    const std::vector<std::shared_ptr<const BagFile>>& files,
    std::vector<const TopicContents*> topics, const std::vector<Camera>& rig,
    const std::vector<Time>& offsets, const std::string& where, std::vector<std::string>& remarks);

}  // namespace chasles
