#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/display.h>
#include <libavutil/opt.h>
}

#include <chasles/base/time.hpp>
#include <chasles/camera/image_frame.hpp>

// Writes videos by FFmpeg's own encoders, for the tests of their readers.
namespace chasles::test {

/// Bytes that a video has at a time, as a payload of telemetry.
struct TimedBytes {
  Time time{}, duration{};
  std::string bytes;
};

/// How a video is written.
struct VideoForm {
  std::string encoder = "libx264";
  std::string options = "";  ///< of the encoder: "crf=10:bf=2"
  AVPixelFormat pixels = AV_PIX_FMT_YUV420P;
  bool full_range = true;
  int key_every = 8;  ///< pictures
  int b_pictures = 2;
  int ticks_per_second = 90'000;
  int turn = 0;  ///< clockwise, of the display matrix [deg]; 0: no matrix
  std::string telemetry_tag = "gpmd";
  bool index_first = false;  ///< moov before mdat
  int videos = 1;            ///< streams with these pictures
  bool sound = false;        ///< a stream of silence
};

/// Where the bytes of the n-th packet of the first stream begin in the file.
inline std::size_t position_of_packet(const std::filesystem::path& file, int n) {
  AVFormatContext* format = nullptr;
  if (avformat_open_input(&format, file.c_str(), nullptr, nullptr) < 0) {
    throw std::runtime_error("cannot open " + file.string());
  }
  AVPacket* packet = av_packet_alloc();
  std::int64_t position = -1;
  while (n >= 0 && av_read_frame(format, packet) >= 0) {
    if (packet->stream_index == 0 && n-- == 0) position = packet->pos;
    av_packet_unref(packet);
  }
  av_packet_free(&packet);
  avformat_close_input(&format);
  return static_cast<std::size_t>(position);
}

class VideoWriter {
 public:
  /// The pictures with their times, which rise, and payloads of telemetry.
  static void write(const std::filesystem::path& file, const std::vector<ImageFrame>& pictures,
                    const VideoForm& form = {}, const std::vector<TimedBytes>& telemetry = {}) {
    VideoWriter(file, form, pictures).write_all(telemetry);
  }

 private:
  VideoWriter(const std::filesystem::path& file, const VideoForm& form,
              const std::vector<ImageFrame>& pictures)
      : form_(form), pictures_(pictures) {
    av_log_set_level(AV_LOG_QUIET);
    check(avformat_alloc_output_context2(&format_, nullptr, "mp4", file.c_str()), "format");
    check(avio_open(&format_->pb, file.c_str(), AVIO_FLAG_WRITE), "file");
  }
  ~VideoWriter() {
    for (AVCodecContext* codec : codecs_) avcodec_free_context(&codec);
    avio_closep(&format_->pb);
    avformat_free_context(format_);
  }
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  static void check(int code, const char* what) {
    if (code < 0) throw std::runtime_error(std::string("cannot write a video: ") + what);
  }

  void write_all(const std::vector<TimedBytes>& telemetry) {
    format_->avoid_negative_ts = 0;  // what is before 0 is cut by an edit list
    for (int v = 0; v < form_.videos; ++v) add_video();
    AVStream* data = telemetry.empty() ? nullptr : add_telemetry();
    AVStream* sound = form_.sound ? add_sound() : nullptr;
    AVDictionary* options = nullptr;
    av_dict_set(&options, "movflags", form_.index_first ? "faststart" : "0", 0);
    av_dict_set_int(&options, "video_track_timescale", form_.ticks_per_second, 0);
    check(avformat_write_header(format_, &options), "header");
    av_dict_free(&options);
    for (const TimedBytes& payload : telemetry) write_payload(*data, payload);
    if (sound != nullptr) write_payload(*sound, {.duration = Time(1'000'000'000), .bytes = "abcd"});
    for (std::size_t v = 0; v < codecs_.size(); ++v) {
      for (std::size_t i = 0; i < pictures_.size(); ++i) encode(v, &pictures_[i]);
      encode(v, nullptr);
    }
    check(av_write_trailer(format_), "trailer");
  }

  void add_video() {
    const AVCodec* encoder = avcodec_find_encoder_by_name(form_.encoder.c_str());
    if (encoder == nullptr) throw std::runtime_error("no encoder " + form_.encoder);
    AVCodecContext* codec = avcodec_alloc_context3(encoder);
    codecs_.push_back(codec);
    codec->width = pictures_.front().images[0].width;
    codec->height = pictures_.front().images[0].height;
    codec->pix_fmt = form_.pixels;
    codec->color_range = form_.full_range ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
    codec->time_base = {1, form_.ticks_per_second};
    codec->framerate = {30, 1};
    codec->gop_size = form_.key_every;
    codec->max_b_frames = form_.b_pictures;
    codec->thread_count = 1;
    codec->strict_std_compliance = FF_COMPLIANCE_UNOFFICIAL;  // limited Motion JPEG
    if ((format_->oformat->flags & AVFMT_GLOBALHEADER) != 0) {
      codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    }
    AVDictionary* options = nullptr;
    av_dict_parse_string(&options, form_.options.c_str(), "=", ":", 0);
    // Key pictures are where `key_every` says, and nowhere else.
    if (form_.encoder == "libx264") av_dict_set(&options, "sc_threshold", "0", 0);
    if (form_.encoder == "libx265") {
      av_dict_set(&options, "x265-params", "log-level=none:scenecut=0", 0);
    }
    const int opened = avcodec_open2(codec, encoder, &options);
    av_dict_free(&options);
    check(opened, "encoder");
    AVStream* stream = avformat_new_stream(format_, nullptr);
    stream->time_base = codec->time_base;
    avcodec_parameters_from_context(stream->codecpar, codec);
    if (form_.turn != 0) {
      av_display_rotation_set(new_matrix(*stream), form_.turn);
    }
  }

  static std::int32_t* new_matrix(AVStream& stream) {
    constexpr std::size_t kBytes = 9 * sizeof(std::int32_t);
#if LIBAVCODEC_VERSION_INT >= AV_VERSION_INT(60, 31, 102)
    AVCodecParameters& of = *stream.codecpar;
    return reinterpret_cast<std::int32_t*>(
        av_packet_side_data_new(&of.coded_side_data, &of.nb_coded_side_data,
                                AV_PKT_DATA_DISPLAYMATRIX, kBytes, 0)
            ->data);
#else
    return reinterpret_cast<std::int32_t*>(
        av_stream_new_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, kBytes));
#endif
  }

  AVStream* add_telemetry() {
    AVStream* stream = avformat_new_stream(format_, nullptr);
    stream->codecpar->codec_type = AVMEDIA_TYPE_DATA;
    stream->codecpar->codec_id = AV_CODEC_ID_BIN_DATA;
    std::memcpy(&stream->codecpar->codec_tag, form_.telemetry_tag.data(), 4);
    stream->time_base = {1, 1'000'000};
    return stream;
  }

  AVStream* add_sound() {
    AVStream* stream = avformat_new_stream(format_, nullptr);
    stream->codecpar->codec_type = AVMEDIA_TYPE_AUDIO;
    stream->codecpar->codec_id = AV_CODEC_ID_MP3;
    stream->codecpar->sample_rate = 48'000;
    stream->codecpar->ch_layout.nb_channels = 1;
    stream->time_base = {1, 48'000};
    return stream;
  }

  void write_payload(const AVStream& stream, const TimedBytes& payload) {
    AVPacket* packet = av_packet_alloc();
    check(av_new_packet(packet, static_cast<int>(payload.bytes.size())), "payload");
    std::memcpy(packet->data, payload.bytes.data(), payload.bytes.size());
    const AVRational ns{1, 1'000'000'000};
    packet->pts = packet->dts = av_rescale_q(payload.time.count(), ns, stream.time_base);
    packet->duration = av_rescale_q(payload.duration.count(), ns, stream.time_base);
    packet->stream_index = stream.index;
    packet->flags |= AV_PKT_FLAG_KEY;
    check(av_interleaved_write_frame(format_, packet), "payload");
    av_packet_free(&packet);
  }

  void encode(std::size_t v, const ImageFrame* picture) {
    AVFrame* frame = picture == nullptr ? nullptr : frame_of(*picture, *codecs_[v]);
    check(avcodec_send_frame(codecs_[v], frame), "picture");
    av_frame_free(&frame);
    AVPacket* packet = av_packet_alloc();
    while (avcodec_receive_packet(codecs_[v], packet) == 0) {
      AVStream* stream = format_->streams[v];
      packet->stream_index = stream->index;
      packet->duration = duration_at(packet->pts, *codecs_[v]);
      av_packet_rescale_ts(packet, codecs_[v]->time_base, stream->time_base);
      check(av_interleaved_write_frame(format_, packet), "packet");
    }
    av_packet_free(&packet);
  }

  // Without it the edit list cuts the last picture.
  std::int64_t duration_at(std::int64_t pts, const AVCodecContext& codec) const {
    std::int64_t next = pts + form_.ticks_per_second / 30;
    for (std::size_t i = pictures_.size(); i-- > 0;) {
      const std::int64_t ticks = ticks_of(pictures_[i], codec);
      if (ticks > pts) next = ticks;
    }
    return next - pts;
  }

  static std::int64_t ticks_of(const ImageFrame& picture, const AVCodecContext& codec) {
    return av_rescale_q(picture.time.count(), {1, 1'000'000'000}, codec.time_base);
  }

  // The grey as luma; chroma is neutral.
  AVFrame* frame_of(const ImageFrame& picture, const AVCodecContext& codec) const {
    AVFrame* frame = av_frame_alloc();
    frame->format = codec.pix_fmt;
    frame->width = codec.width;
    frame->height = codec.height;
    frame->color_range = codec.color_range;
    check(av_frame_get_buffer(frame, 0), "frame");
    const bool deep = codec.pix_fmt == AV_PIX_FMT_YUV420P10LE;
    const GrayImage& grey = picture.images[0];
    for (int v = 0; v < grey.height; ++v) {
      for (int u = 0; u < grey.width; ++u) {
        const int luma = luma_of(grey.pixels[static_cast<std::size_t>(v * grey.width + u)], deep);
        std::uint8_t* row = frame->data[0] + std::ptrdiff_t{v} * frame->linesize[0];
        if (deep) {
          reinterpret_cast<std::uint16_t*>(row)[u] = static_cast<std::uint16_t>(luma);
        } else {
          row[u] = static_cast<std::uint8_t>(luma);
        }
      }
    }
    for (int plane = 1; plane < 3; ++plane) {
      const int rows = (codec.height + 1) / 2;
      std::uint8_t* bytes = frame->data[plane];
      const auto size = static_cast<std::size_t>(rows * frame->linesize[plane]);
      if (deep) {
        auto* values = reinterpret_cast<std::uint16_t*>(bytes);
        std::fill(values, values + size / 2, std::uint16_t{512});
      } else {
        std::memset(bytes, 128, size);
      }
    }
    frame->pts = ticks_of(picture, codec);
    return frame;
  }

  // ITU-R BT.709: 0 to 255 becomes 16 to 235, times four of ten bits.
  int luma_of(int grey, bool deep) const {
    const double value = form_.full_range ? grey * (deep ? 1023.0 / 255 : 1)
                                          : (16 + grey * 219.0 / 255) * (deep ? 4 : 1);
    return static_cast<int>(value + 0.5);
  }

  VideoForm form_;
  const std::vector<ImageFrame>& pictures_;
  AVFormatContext* format_ = nullptr;
  std::vector<AVCodecContext*> codecs_;
};

}  // namespace chasles::test
