#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <chasles/video/libav.hpp>

namespace chasles {

/// What frees the structs of FFmpeg's libraries.
struct LibavDeleter {
  const Libav* av = nullptr;
  void operator()(AVFormatContext* format) const { av->close_input(&format); }
  void operator()(AVCodecContext* codec) const { av->free_context(&codec); }
  void operator()(AVPacket* packet) const { av->packet_free(&packet); }
  void operator()(AVFrame* frame) const { av->frame_free(&frame); }
};
template <typename Struct>
using LibavPtr = std::unique_ptr<Struct, LibavDeleter>;

/// An MP4 or QuickTime file with one video: its streams and their packets, undecoded. Other files,
/// and addresses of a network, are not opened.
class Container {
 public:
  enum class Telemetry { kRead, kSkip };

  /// Throws InputError, starting with the file's name, for a file without an index, without a video
  /// or with several, and for a codec that is not read.
  Container(const std::filesystem::path& file, Telemetry telemetry);

  const Libav& av() const { return *av_; }
  const std::string& name() const { return name_; }
  const AVStream& video() const { return *format_->streams[video_]; }
  /// The stream of a GoPro's telemetry (gpmd).
  const AVStream* telemetry() const { return telemetry_ ? format_->streams[*telemetry_] : nullptr; }
  /// The packets of the video that the file's index lists.
  int listed_packets() const;
  /// The next packet of the video or of the telemetry; nullptr at the end of what can be read. It
  /// is valid until the next call.
  const AVPacket* next();
  /// Continues at the last picture at or before `pts` at which decoding can begin.
  void seek(std::int64_t pts);

 private:
  void open();
  void choose_streams(Telemetry telemetry);

  std::string name_;
  const Libav* av_;
  LibavPtr<AVFormatContext> format_;
  LibavPtr<AVPacket> packet_;
  int video_ = -1;
  std::optional<int> telemetry_;
};

}  // namespace chasles
