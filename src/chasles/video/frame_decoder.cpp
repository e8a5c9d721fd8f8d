#include <algorithm>
#include <limits>
#include <new>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/video/container.hpp>
#include <chasles/video/frame_decoder.hpp>
#include <chasles/video/grey_frame_detail.hpp>

namespace chasles {
namespace {

constexpr std::int64_t kLargestPictures = 100'000'000;  // [px], as for images
constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min();

LibavPtr<AVCodecContext> open_decoder(const Container& container) {
  const Libav& av = container.av();
  const AVCodecParameters& stream = *container.video().codecpar;
  const AVCodec* codec = av.find_decoder(stream.codec_id);
  if (codec == nullptr) {
    throw InputError(fmt::format(
        "{}: FFmpeg's libraries here have no decoder of {}: install those with all codecs",
        container.name(), av.codec_name(stream.codec_id)));
  }
  LibavPtr<AVCodecContext> context(av.alloc_context(codec), {&av});
  if (!context || av.parameters_to_context(context.get(), &stream) < 0) throw std::bad_alloc();
  context->thread_count = 1;  // then an error belongs to the packet that was sent
  context->max_pixels = kLargestPictures;
  // H.264 says of each picture what is wrong with it; the others say it by failing alone.
  if (stream.codec_id != AV_CODEC_ID_H264) context->err_recognition |= AV_EF_EXPLODE;
  context->pkt_timebase = container.video().time_base;
  const int error = av.open_codec(context.get(), codec, nullptr);
  if (error >= 0) return context;
  throw InputError(fmt::format("{}: its pictures cannot be decoded ({})", container.name(),
                               libav_error(av, error)));
}

}  // namespace

/// A pass through the file.
class FrameDecoder::Session {
 public:
  explicit Session(const VideoIndex& index)
      : index_(&index),
        container_(index.file, Container::Telemetry::kSkip),
        codec_(open_decoder(container_)),
        frame_(container_.av().frame_alloc(), {&container_.av()}) {
    if (!frame_) throw std::bad_alloc();
  }

  GrayImage read(std::size_t i) {
    const VideoPicture& wanted = index_->pictures[i];
    go_to(wanted.pts);
    while (shown_ < wanted.pts && decode_next(wanted.pts)) {
    }
    const std::string where =
        fmt::format("{}: the picture at {:.6f} s", index_->file, to_seconds(wanted.time));
    if (shown_ != wanted.pts || is_damaged_) {
      throw InputError(where + " is damaged, or is predicted from a damaged one");
    }
    return grey_of(container_.av(), *frame_, where);
  }

 private:
  const VideoKey* key_before(std::int64_t pts) const {
    const auto after = std::ranges::upper_bound(index_->keys, pts, {}, &VideoKey::pts);
    return after == index_->keys.begin() ? nullptr : &*(after - 1);
  }

  // Back, or ahead to a key picture that the pass has not reached.
  void go_to(std::int64_t pts) {
    const VideoKey* key = key_before(pts);
    const bool back = pts < shown_ || sent_ == kNever;
    const bool ahead = key != nullptr && key->dts > sent_ && key->pts > shown_ && skips(*key);
    if (!back && !ahead) return;
    container_.seek(key == nullptr ? index_->keys.front().pts : key->pts);
    container_.av().flush(codec_.get());
    container_.av().frame_unref(frame_.get());
    shown_ = sent_ = sent_pts_ = damaged_until_ = kNever;
    has_ended_ = false;
  }

  // Whether pictures lie between the last one and a key picture.
  bool skips(const VideoKey& key) const {
    const auto next = std::ranges::upper_bound(index_->pictures, shown_, {}, &VideoPicture::pts);
    return next != index_->pictures.end() && next->pts < key.pts;
  }

  // Decodes until there is one more picture. False at the end.
  bool decode_next(std::int64_t wanted) {
    for (;;) {
      const int error = container_.av().receive_frame(codec_.get(), frame_.get());
      if (error == 0) {
        take_frame();
        return true;
      }
      if (error != AVERROR(EAGAIN) && error != AVERROR_EOF) mark_damage(sent_pts_);
      if (error == AVERROR_EOF || has_ended_) return false;
      send(wanted);
    }
  }

  void send(std::int64_t wanted) {
    const Libav& av = container_.av();
    const AVPacket* packet = container_.next();
    if (packet == nullptr || (packet->flags & AV_PKT_FLAG_CORRUPT) != 0) {
      av.send_packet(codec_.get(), nullptr);  // what it holds back comes out
      has_ended_ = true;
      return;
    }
    if (packet->pts == AV_NOPTS_VALUE || packet->dts == AV_NOPTS_VALUE) return;
    // In H.265 pictures of a higher layer may be predicted from what it calls no reference.
    const bool skip = packet->pts < wanted && codec_->codec_id == AV_CODEC_ID_H264;
    codec_->skip_frame = skip ? AVDISCARD_NONREF : AVDISCARD_DEFAULT;
    sent_ = packet->dts;
    sent_pts_ = packet->pts;
    if (av.send_packet(codec_.get(), packet) < 0) mark_damage(packet->pts);
  }

  // All pictures until the next key picture may be predicted from a damaged one, also earlier ones
  // that were not yet shown.
  void mark_damage(std::int64_t pts) {
    const auto key = std::ranges::upper_bound(index_->keys, pts, {}, &VideoKey::pts);
    damaged_until_ =
        key == index_->keys.end() ? std::numeric_limits<std::int64_t>::max() : key->pts;
  }

  void take_frame() {
    shown_ = frame_->best_effort_timestamp;
    const bool flawed =
        frame_->decode_error_flags != 0 || (frame_->flags & AV_FRAME_FLAG_CORRUPT) != 0;
    if (flawed) mark_damage(shown_);
    is_damaged_ = shown_ < damaged_until_;
  }

  const VideoIndex* index_;
  Container container_;
  LibavPtr<AVCodecContext> codec_;
  LibavPtr<AVFrame> frame_;         // the last picture
  bool is_damaged_ = false;         // that one
  std::int64_t shown_ = kNever;     // its pts
  std::int64_t sent_ = kNever;      // the dts of the last packet,
  std::int64_t sent_pts_ = kNever;  // and its pts
  std::int64_t damaged_until_ = kNever;
  bool has_ended_ = false;  // all packets are sent
};

FrameDecoder::FrameDecoder(std::shared_ptr<const VideoIndex> index) : index_(std::move(index)) {}
FrameDecoder::FrameDecoder(FrameDecoder&&) noexcept = default;
FrameDecoder& FrameDecoder::operator=(FrameDecoder&&) noexcept = default;
FrameDecoder::~FrameDecoder() = default;

GrayImage FrameDecoder::read(std::size_t i) {
  if (!session_) session_ = std::make_unique<Session>(*index_);
  return session_->read(i);
}

}  // namespace chasles
