#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <chasles/codec/image_source.hpp>

namespace chasles {

/// The frames of a source within [from, to], with the images of the first `cameras` cameras (all,
/// if there are fewer). Reads no image.
std::shared_ptr<const ImageSource> part_of(std::shared_ptr<const ImageSource> images, Time from,
                                           Time to, std::size_t cameras);

/// These cameras of a source, in this order; without the frames in which none of them has an image.
/// Reads no image.
std::shared_ptr<const ImageSource> chosen_cameras(std::shared_ptr<const ImageSource> images,
                                                  std::vector<std::size_t> cameras);

}  // namespace chasles
