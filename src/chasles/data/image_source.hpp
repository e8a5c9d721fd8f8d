#pragma once

#include <cstddef>

#include <chasles/camera/image_frame.hpp>

namespace chasles {

/// The images of a recording, in the order of time: read when they are asked for, since all of them
/// together may be larger than the memory.
class ImageSource {
 public:
  virtual ~ImageSource() = default;

  virtual std::size_t size() const = 0;
  /// Of the i-th frame; they rise strictly.
  virtual Time time(std::size_t i) const = 0;
  /// Decodes the i-th frame. Throws InputError, with the file's name, where an image is damaged, or
  /// is not of the size that the calibration says. Only one thread may call it at a time, unless
  /// a source says otherwise.
  virtual ImageFrame read(std::size_t i) const = 0;
};

}  // namespace chasles
