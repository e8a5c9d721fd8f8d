#include <algorithm>
#include <array>
#include <new>
#include <vector>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/video/container.hpp>

namespace chasles {
namespace {

constexpr std::array kReadCodecs{AV_CODEC_ID_H264, AV_CODEC_ID_HEVC, AV_CODEC_ID_MJPEG};

// Of a large file with its index at its end, these are the words that help.
std::string without_index(const std::string& file, const std::string& error) {
  return fmt::format(
      "{}: its index cannot be read ({}): the camera writes it (moov) as the last part of a "
      "recording, so the recording or the copy of it broke off; copy it again, or let the camera "
      "repair it",
      file, error);
}

bool is_video(const AVStream& stream) {
  return stream.codecpar->codec_type == AVMEDIA_TYPE_VIDEO &&
         (stream.disposition & AV_DISPOSITION_ATTACHED_PIC) == 0;  // the picture of a cover
}

void check_codec(const std::string& file, const Libav& av, AVCodecID codec) {
  if (std::ranges::find(kReadCodecs, codec) != kReadCodecs.end()) return;
  throw InputError(
      fmt::format("{}: its pictures are {}, expected H.264, H.265 or Motion JPEG: convert them "
                  "with `ffmpeg -i {} -fps_mode passthrough -c:v libx264 -crf 12 NEW.mp4`",
                  file, av.codec_name(codec), file));
}

}  // namespace

Container::Container(const std::filesystem::path& file, Telemetry telemetry)
    : name_(file.string()), av_(&libav(name_)), packet_(av_->packet_alloc(), {av_}) {
  check_regular_file(file);
  if (!packet_) throw std::bad_alloc();
  open();
  choose_streams(telemetry);
}

void Container::open() {
  AVFormatContext* format = nullptr;
  AVDictionary* options = nullptr;
  av_->dict_set(&options, "protocol_whitelist", "file", 0);
  const std::string address = "file:" + name_;  // a name with a colon is no address
  const int error =
      av_->open_input(&format, address.c_str(), av_->find_input_format("mov"), &options);
  av_->dict_free(&options);
  if (error < 0) throw InputError(without_index(name_, libav_error(*av_, error)));
  format_ = LibavPtr<AVFormatContext>(format, {av_});
}

void Container::choose_streams(Telemetry wanted) {
  std::vector<int> videos;
  for (unsigned i = 0; i < format_->nb_streams; ++i) {
    AVStream& stream = *format_->streams[i];
    stream.discard = AVDISCARD_ALL;
    if (is_video(stream)) videos.push_back(static_cast<int>(i));
    const bool gpmd = stream.codecpar->codec_tag == MKTAG('g', 'p', 'm', 'd');
    if (gpmd && wanted == Telemetry::kRead && !telemetry_) {
      telemetry_ = static_cast<int>(i);
      stream.discard = AVDISCARD_DEFAULT;
    }
  }
  if (videos.size() != 1) {
    throw InputError(fmt::format(
        "{}: has {} videos in {} streams, expected one: {}", name_, videos.size(),
        format_->nb_streams,
        videos.empty() ? "a recording of sound or of telemetry alone has no pictures"
                       : "write each into a file of its own (`ffmpeg -i FILE -map 0:v:0 -c copy "
                         "NEW.mp4`)"));
  }
  video_ = videos.front();
  format_->streams[video_]->discard = AVDISCARD_DEFAULT;
  check_codec(name_, *av_, video().codecpar->codec_id);
}

int Container::listed_packets() const { return av_->index_entries(format_->streams[video_]); }

const AVPacket* Container::next() {
  do {
    av_->packet_unref(packet_.get());
    if (av_->read_packet(format_.get(), packet_.get()) < 0) return nullptr;
  } while (packet_->stream_index != video_ && packet_->stream_index != telemetry_);
  return packet_.get();
}

void Container::seek(std::int64_t pts) {
  const int error = av_->seek(format_.get(), video_, pts, AVSEEK_FLAG_BACKWARD);
  if (error >= 0) return;
  throw InputError(
      fmt::format("{}: cannot be read from the picture {} on ({}): its index is damaged", name_,
                  pts, libav_error(*av_, error)));
}

}  // namespace chasles
