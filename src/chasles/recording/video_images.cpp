#include <cmath>
#include <cstdlib>
#include <utility>

#include <fmt/format.h>

#include <chasles/recording/video_images.hpp>

namespace chasles {
namespace {

class VideoImages : public ImageSource {
 public:
  VideoImages(std::shared_ptr<const VideoIndex> index, std::vector<Time> times,
              const Camera& camera)
      : decoder_(std::move(index)),
        times_(std::move(times)),
        width_(camera.width),
        height_(camera.height) {}

  std::size_t size() const override { return times_.size(); }
  Time time(std::size_t i) const override { return times_[i]; }
  ImageFrame read(std::size_t i) const override { return read_undamaged(i, 1, &throw_damage); }
  ImageFrame read_cameras(std::size_t i, std::size_t cameras) const override {
    return read_undamaged(i, cameras, &throw_damage);
  }
  ImageFrame read_undamaged(std::size_t i, std::size_t cameras,
                            const OnDamage& damaged) const override {
    ImageFrame frame{.time = times_[i], .images = {}};
    if (cameras > 0) {
      frame.images.push_back(read_or_empty([&] { return picture(i); }, damaged));
    }
    return frame;
  }

 private:
  // The index states one size; a video may change it.
  GrayImage picture(std::size_t i) const {
    GrayImage image = decoder_.read(i);
    if (image.width == width_ && image.height == height_) return image;
    throw ImageSizeError(fmt::format(
        "{}: the picture at {:.6f} s has {} x {} pixels, expected {} x {} as in the calibration",
        decoder_.index().file, to_seconds(decoder_.index().pictures[i].time), image.width,
        image.height, width_, height_));
  }

  mutable FrameDecoder decoder_;  // where it is in the file is no part of what is read
  std::vector<Time> times_;
  int width_, height_;
};

// Of a calibration from images that were made smaller or larger.
std::string scale_advice(const VideoIndex& index, const Camera& camera) {
  const double across = static_cast<double>(index.width) / camera.width,
               down = static_cast<double>(index.height) / camera.height;
  if (std::abs(across - down) * camera.height > 1) {
    return "take a calibration of this size and field of view (mode, zoom and stabilisation change "
           "both)";
  }
  return fmt::format(
      "if it is from the same pictures in another size, {0:.6g} times as large: multiply fx and fy "
      "by {0:.6g}, and write (c + 0.5) * {0:.6g} - 0.5 for cx and cy; the distortion stays",
      across);
}

}  // namespace

std::shared_ptr<const ImageSource> open_video_images(VideoIndex index, std::vector<Time> times,
                                                     const Camera& camera) {
  if (index.width != camera.width || index.height != camera.height) {
    throw InputError(fmt::format(
        "{}: its pictures have {} x {} pixels, expected {} x {} as in the calibration: {}",
        index.file, index.width, index.height, camera.width, camera.height,
        scale_advice(index, camera)));
  }
  return std::make_shared<VideoImages>(std::make_shared<const VideoIndex>(std::move(index)),
                                       std::move(times), camera);
}

}  // namespace chasles
