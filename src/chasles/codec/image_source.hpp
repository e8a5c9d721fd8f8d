#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include <chasles/base/error.hpp>
#include <chasles/camera/image_frame.hpp>

namespace chasles {

/// An image whose size is not that of the calibration.
class ImageSizeError : public InputError {
 public:
  using InputError::InputError;
};

/// Called with the error of an image that cannot be read.
using OnDamage = std::function<void(const InputError&)>;

/// The images of a recording in order of time. They are read on request, because all of them
/// together may be larger than the memory.
class ImageSource {
 public:
  virtual ~ImageSource() = default;

  virtual std::size_t size() const = 0;
  /// The time of the i-th frame; times rise strictly.
  virtual Time time(std::size_t i) const = 0;
  /// Decodes the i-th frame. Throws InputError with the file's name if an image is damaged, and
  /// ImageSizeError if its size differs from the calibration. Only one thread at a time may call
  /// it, unless the source documents otherwise.
  virtual ImageFrame read(std::size_t i) const = 0;
  /// The same with the images of the first `cameras` cameras only (all, if there are fewer).
  /// Sources that decode their images decode no other.
  virtual ImageFrame read_cameras(std::size_t i, std::size_t cameras) const {
    ImageFrame frame = read(i);
    if (frame.images.size() > cameras) frame.images.resize(cameras);
    return frame;
  }
  /// The same, but an image that cannot be read is empty, and `damaged` receives its error. Sources
  /// that read all images of a frame at once throw the error instead.
  virtual ImageFrame read_undamaged(std::size_t i, std::size_t cameras,
                                    const OnDamage& /*damaged*/) const {
    return read_cameras(i, cameras);
  }
  /// The same with the images of these cameras only, in this order.
  virtual ImageFrame read_chosen(std::size_t i, const std::vector<std::size_t>& cameras,
                                 const OnDamage& damaged) const {
    ImageFrame all = read_undamaged(i, std::ranges::max(cameras) + 1, damaged);
    ImageFrame frame{.time = all.time, .images = {}};
    for (const std::size_t camera : cameras) {
      frame.images.push_back(camera < all.images.size() ? std::move(all.images[camera])
                                                        : GrayImage{});
    }
    return frame;
  }
  /// False if it is known without reading that the camera has no image in the frame.
  virtual bool has_image(std::size_t /*i*/, std::size_t /*camera*/) const { return true; }
};

/// The image that `read` returns; an empty one if it throws InputError, which `damaged` receives.
template <typename Read>
GrayImage read_or_empty(const Read& read, const OnDamage& damaged) {
  try {
    return read();
  } catch (const InputError& error) {
    damaged(error);
    return {};
  }
}

/// For read_or_empty(): the error is thrown on.
inline void throw_damage(const InputError&) { throw; }

}  // namespace chasles
