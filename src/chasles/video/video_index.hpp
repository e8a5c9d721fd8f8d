#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <chasles/base/time.hpp>

namespace chasles {

/// When a picture of a video is shown.
struct VideoPicture {
  Time time{};           ///< since the start of the video, as the file states it
  std::int64_t pts = 0;  ///< the same in ticks of the file
};

/// A picture at which decoding can begin: when it is shown, and when it is decoded [ticks]. An edit
/// list may cut it from what is shown.
struct VideoKey {
  std::int64_t pts = 0, dts = 0;
};

/// A payload of telemetry in a video.
struct TelemetryPayload {
  Time time{}, duration{};  ///< as the file states them
  std::string bytes;
};

/// What a video has, without its pictures.
struct VideoIndex {
  std::string file;
  std::string codec;                        ///< "h264"
  int width = 0, height = 0;                ///< of the pictures as they are stored [px]
  int turn = 0;                             ///< clockwise, for players [deg]; 0 to 359
  std::vector<VideoPicture> pictures;       ///< times rise strictly
  std::vector<VideoKey> keys;               ///< in the order of `pts`
  std::vector<TelemetryPayload> telemetry;  ///< of a GoPro, in the order of the file
};

/// Reads the index and all packets of a video, and decodes none: the times of its pictures as they
/// are stored, also those of a variable rate, in the order of display and after edit lists. Remarks
/// are on packets that are missing at the end, have no time or that of another, and on a turn for
/// players. Throws InputError, starting with the file's name: as Container, and for a video without
/// pictures.
VideoIndex read_video_index(const std::filesystem::path& file, std::vector<std::string>& remarks);

}  // namespace chasles
