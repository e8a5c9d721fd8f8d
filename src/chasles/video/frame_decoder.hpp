#pragma once

#include <cstddef>
#include <memory>

#include <chasles/camera/image_frame.hpp>
#include <chasles/video/video_index.hpp>

namespace chasles {

/// Decodes the pictures of a video to 8 bits of grey. Reading on is a pass through the file; an
/// earlier picture, or one behind a key picture that was not yet reached, is read from the key
/// picture before it. Pictures between that nothing else is predicted from are not decoded.
///
/// Grey is the luma of the video. A limited range (16 to 235, or 64 to 940 of ten bits) becomes 0
/// to 255, as its file states it; without a statement it is limited, but for Motion JPEG. Pictures
/// of ten bits are rounded to eight. The pixels depend on the file alone: one thread decodes it.
class FrameDecoder {
 public:
  /// `index`: of a video that is still there. It is opened at the first read().
  explicit FrameDecoder(std::shared_ptr<const VideoIndex> index);
  FrameDecoder(FrameDecoder&&) noexcept;
  FrameDecoder& operator=(FrameDecoder&&) noexcept;
  ~FrameDecoder();

  const VideoIndex& index() const { return *index_; }
  /// The i-th picture. Throws InputError with the file's name and its time if it is damaged, as all
  /// pictures from a damaged one to the next key picture are, or has another form of pixels.
  GrayImage read(std::size_t i);

 private:
  class Session;
  std::shared_ptr<const VideoIndex> index_;
  std::unique_ptr<Session> session_;
};

}  // namespace chasles
