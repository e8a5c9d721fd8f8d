#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/codec/read_budget.hpp>
#include <chasles/video/container.hpp>
#include <chasles/video/video_index.hpp>

namespace chasles {
namespace {

constexpr AVRational kNanoseconds{1, 1'000'000'000};

/// What does not become a picture.
struct PacketCounts {
  int read = 0, without_time = 0, repeated = 0;
};

Time time_of(const Container& container, const AVStream& stream, std::int64_t ticks) {
  const std::int64_t ns = container.av().rescale_q(ticks, stream.time_base, kNanoseconds);
  if (ns > -kLastNanosecond && ns < kLastNanosecond) return Time(ns);
  throw InputError(
      fmt::format("{}: a picture has the time {} in ticks of {}/{} s, which is no "
                  "time: its index is damaged",
                  container.name(), ticks, stream.time_base.num, stream.time_base.den));
}

void add_picture(const Container& container, const AVPacket& packet, VideoIndex& index,
                 PacketCounts& counts) {
  ++counts.read;
  if (packet.pts == AV_NOPTS_VALUE || packet.dts == AV_NOPTS_VALUE) {
    ++counts.without_time;
    return;
  }
  if ((packet.flags & AV_PKT_FLAG_KEY) != 0) {
    index.keys.push_back({.pts = packet.pts, .dts = packet.dts});
  }
  if ((packet.flags & AV_PKT_FLAG_DISCARD) != 0) return;  // cut by an edit list
  index.pictures.push_back(
      {.time = time_of(container, container.video(), packet.pts), .pts = packet.pts});
}

void put_in_order(VideoIndex& index, PacketCounts& counts) {
  std::ranges::stable_sort(index.keys, {}, &VideoKey::pts);
  std::ranges::stable_sort(index.pictures, {}, &VideoPicture::pts);
  // Ticks may be shorter than a nanosecond.
  const auto same =
      std::unique(index.pictures.begin(), index.pictures.end(),
                  [](const VideoPicture& a, const VideoPicture& b) { return a.time == b.time; });
  counts.repeated = static_cast<int>(index.pictures.end() - same);
  index.pictures.erase(same, index.pictures.end());
}

// The matrix of the file turns the picture clockwise where its angle is negative.
int turn_of(const Libav& av, const AVStream& stream) {
  constexpr int kWhole = 360;
  const std::int32_t* matrix = nullptr;
#if LIBAVCODEC_VERSION_INT >= AV_VERSION_INT(60, 31, 102)
  const AVCodecParameters& of = *stream.codecpar;
  for (int i = 0; i < of.nb_coded_side_data; ++i) {
    const AVPacketSideData& data = of.coded_side_data[i];
    if (data.type == AV_PKT_DATA_DISPLAYMATRIX) {
      matrix = reinterpret_cast<const std::int32_t*>(data.data);
    }
  }
#else
  for (int i = 0; i < stream.nb_side_data; ++i) {
    const AVPacketSideData& data = stream.side_data[i];
    if (data.type == AV_PKT_DATA_DISPLAYMATRIX) {
      matrix = reinterpret_cast<const std::int32_t*>(data.data);
    }
  }
#endif
  const double angle = matrix == nullptr ? 0 : av.display_rotation(matrix);
  if (!std::isfinite(angle)) return 0;
  return (kWhole - static_cast<int>(std::lround(angle)) % kWhole) % kWhole;
}

void add_remarks(const VideoIndex& index, int listed, const PacketCounts& counts,
                 std::vector<std::string>& remarks) {
  if (counts.read < listed) {
    remarks.push_back(fmt::format(
        "{} of {} pictures that the video lists are not in it: it is cut, and ends {:.2f} s after "
        "its start",
        listed - counts.read, listed, to_seconds(index.pictures.back().time)));
  }
  if (counts.without_time > 0) {
    remarks.push_back(fmt::format("{} of {} pictures of the video have no time: left out",
                                  counts.without_time, counts.read));
  }
  if (counts.repeated > 0) {
    remarks.push_back(
        fmt::format("{} of {} pictures of the video repeat the time of another: left "
                    "out",
                    counts.repeated, counts.read));
  }
  if (index.turn != 0) {
    remarks.push_back(fmt::format(
        "players show this video turned by {} deg clockwise; it is read as it is stored, {} x {}, "
        "and the calibration is that of these pixels",
        index.turn, index.width, index.height));
  }
}

}  // namespace

VideoIndex read_video_index(const std::filesystem::path& file, std::vector<std::string>& remarks) {
  Container container(file, Container::Telemetry::kRead);
  const AVStream& video = container.video();
  VideoIndex index{.file = container.name(),
                   .codec = container.av().codec_name(video.codecpar->codec_id),
                   .width = video.codecpar->width,
                   .height = video.codecpar->height,
                   .turn = turn_of(container.av(), video),
                   .pictures = {},
                   .keys = {},
                   .telemetry = {}};
  PacketCounts counts;
  std::size_t telemetry_bytes = 0;
  while (const AVPacket* packet = container.next()) {
    if ((packet->flags & AV_PKT_FLAG_CORRUPT) != 0) break;  // the file ends within it
    if (packet->stream_index == video.index) {
      add_picture(container, *packet, index, counts);
      continue;
    }
    telemetry_bytes += static_cast<std::size_t>(packet->size);
    check_memory(fmt::format("{}: has {} bytes of telemetry", index.file, telemetry_bytes),
                 telemetry_bytes);
    const AVStream& telemetry = *container.telemetry();
    if (packet->pts == AV_NOPTS_VALUE) continue;
    index.telemetry.push_back({.time = time_of(container, telemetry, packet->pts),
                               .duration = time_of(container, telemetry, packet->duration),
                               .bytes = {reinterpret_cast<const char*>(packet->data),
                                         static_cast<std::size_t>(packet->size)}});
  }
  put_in_order(index, counts);
  if (index.pictures.empty() || index.keys.empty()) {
    throw InputError(fmt::format(
        "{}: holds no picture that can be decoded, expected those of a camera: the recording or "
        "the copy of it broke off",
        index.file));
  }
  add_remarks(index, container.listed_packets(), counts, remarks);
  return index;
}

}  // namespace chasles
