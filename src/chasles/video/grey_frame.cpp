#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/video/grey_frame_detail.hpp>

namespace chasles {
namespace {

/// The luma of a picture: its bits, and whether all their values are used.
struct Luma {
  int bits = 8;
  bool full = false;
};

constexpr std::uint64_t kNoLuma =
    AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL | AV_PIX_FMT_FLAG_BE | AV_PIX_FMT_FLAG_BITSTREAM;

Luma luma_of(const Libav& av, const AVFrame& frame, const std::string& where) {
  const AVPixFmtDescriptor* format = av.pixel_format(static_cast<AVPixelFormat>(frame.format));
  const bool planar =
      format != nullptr && (format->flags & kNoLuma) == 0 && format->comp[0].plane == 0;
  const int bits = planar ? format->comp[0].depth : 0;
  if ((bits != 8 && bits != 10) || format->comp[0].step != (bits + 7) / 8 ||
      format->comp[0].shift != 0 || format->comp[0].offset != 0) {
    throw InputError(fmt::format(
        "{}: its pixels are {}, expected YUV or grey of 8 or 10 bits: convert the video with "
        "`ffmpeg -i FILE -fps_mode passthrough -pix_fmt yuv420p -c:v libx264 -crf 12 NEW.mp4`",
        where, format == nullptr ? "of an unknown form" : format->name));
  }
  const bool of_jpeg = std::string_view(format->name).starts_with("yuvj");
  return {.bits = bits, .full = of_jpeg || frame.color_range == AVCOL_RANGE_JPEG};
}

// The grey of each value (ITU-R BT.709: limited luma is 16 to 235 of 8 bits, times four of 10).
std::vector<std::uint8_t> grey_of_values(const Luma& luma) {
  constexpr int kWhite = 255;
  const int values = 1 << luma.bits, unit = values / 256;
  const int black = luma.full ? 0 : 16 * unit, white = luma.full ? values - 1 : 235 * unit;
  std::vector<std::uint8_t> greys;
  for (int value = 0; value < values; ++value) {
    const int scaled = kWhite * (std::clamp(value, black, white) - black);
    greys.push_back(
        static_cast<std::uint8_t>((2 * scaled + white - black) / (2 * (white - black))));
  }
  return greys;
}

template <typename Value>
void take_row(const std::uint8_t* row, int width, const std::vector<std::uint8_t>& greys,
              std::uint8_t* out) {
  for (int u = 0; u < width; ++u) {
    Value value;
    std::memcpy(&value, row + static_cast<std::size_t>(u) * sizeof(Value), sizeof(Value));
    out[u] = greys[std::min<std::size_t>(value, greys.size() - 1)];
  }
}

}  // namespace

GrayImage grey_of(const Libav& av, const AVFrame& frame, const std::string& where) {
  const Luma luma = luma_of(av, frame, where);
  const std::vector<std::uint8_t> greys = grey_of_values(luma);
  const auto width = static_cast<std::size_t>(frame.width),
             height = static_cast<std::size_t>(frame.height);
  GrayImage image{.width = frame.width, .height = frame.height, .pixels = {}};
  image.pixels.resize(width * height);
  for (std::size_t v = 0; v < height; ++v) {
    const std::uint8_t* row = frame.data[0] + static_cast<std::ptrdiff_t>(v) * frame.linesize[0];
    std::uint8_t* out = image.pixels.data() + v * width;
    if (luma.bits == 8 && luma.full) {  // as they are
      std::copy_n(row, width, out);
    } else if (luma.bits == 8) {
      take_row<std::uint8_t>(row, frame.width, greys, out);
    } else {
      take_row<std::uint16_t>(row, frame.width, greys, out);
    }
  }
  return image;
}

}  // namespace chasles
