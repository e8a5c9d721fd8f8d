#pragma once

#include <string>

#include <chasles/camera/image_frame.hpp>
#include <chasles/video/libav.hpp>

namespace chasles {

/// The grey of a decoded picture (FrameDecoder). Throws InputError, starting with `where`, for a
/// form of pixels that has no luma of 8 or 10 bits.
GrayImage grey_of(const Libav& av, const AVFrame& frame, const std::string& where);

}  // namespace chasles
