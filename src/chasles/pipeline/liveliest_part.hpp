#pragma once

#include <memory>

#include <chasles/recording/recording.hpp>

namespace chasles {

/// The images of a part of at most `seconds` [s]: the part with the most rotation by the gyroscope,
/// or the first part if there is no IMU. The recording has images.
std::shared_ptr<const ImageSource> liveliest_part(const Recording& recording, double seconds);

}  // namespace chasles
