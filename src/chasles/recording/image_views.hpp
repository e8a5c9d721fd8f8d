#pragma once

#include <memory>

#include <chasles/codec/image_source.hpp>

namespace chasles {

/// The frames of a source within [from, to], with the images of the first `cameras` cameras (all,
/// if there are fewer). Reads no image.
std::shared_ptr<const ImageSource> part_of(std::shared_ptr<const ImageSource> images, Time from,
                                           Time to, std::size_t cameras);

}  // namespace chasles
