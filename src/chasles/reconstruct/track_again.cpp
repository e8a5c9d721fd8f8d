#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>

#include <chasles/pipeline/recording_sensors.hpp>
#include <chasles/pipeline/sensor_feed.hpp>
#include <chasles/reconstruct/sharpness.hpp>
#include <chasles/reconstruct/track_again.hpp>
#include <chasles/recording/masks.hpp>
#include <chasles/viewers/run_path.hpp>

namespace chasles {
namespace {

// The biases of the gyroscope along a run.
class EstimatedBiases {
 public:
  explicit EstimatedBiases(const Run& run)
      : run_(run), column_(extra_vector_at(run, "gyroscope_bias")) {}

  // At the last state up to that time, which rises from call to call; zero before the first one.
  const Eigen::Vector3d& at(Time time) {
    for (; column_ && next_ < run_.states.size() && run_.states[next_].time <= time; ++next_) {
      const std::vector<double>& extra = run_.states[next_].extra;
      const Eigen::Vector3d bias(extra[*column_], extra[*column_ + 1], extra[*column_ + 2]);
      if (bias.allFinite()) last_ = bias;
    }
    return last_;
  }

 private:
  const Run& run_;
  std::optional<std::size_t> column_;
  std::size_t next_ = 0;
  Eigen::Vector3d last_ = Eigen::Vector3d::Zero();
};

std::uint8_t grey_at(const GrayImage& image, const Eigen::Vector2d& pixel) {
  const auto x = std::clamp(static_cast<int>(std::lround(pixel.x())), 0, image.width - 1);
  const auto y = std::clamp(static_cast<int>(std::lround(pixel.y())), 0, image.height - 1);
  return image.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                      static_cast<std::size_t>(x)];
}

TrackedImages tracked_images(const FeatureFrame& frame) {
  TrackedImages tracked{.time = frame.time};
  if (!frame.images) return tracked;
  const std::vector<GrayImage>& images = frame.images->images;
  int count = 0;
  for (const GrayImage& image : images) {
    if (image.empty()) continue;
    tracked.sharpness += sharpness(image);
    ++count;
  }
  if (count > 0) tracked.sharpness /= count;
  for (const PixelObservation& o : frame.pixels) {
    const GrayImage& image = images[static_cast<std::size_t>(o.camera)];
    tracked.pixels.push_back({.track = o.landmark,
                              .pixel = o.pixel,
                              .camera = static_cast<std::uint8_t>(o.camera),
                              .grey = grey_at(image, o.pixel)});
  }
  return tracked;
}

}  // namespace

std::vector<TrackedImages> track_again(const Recording& recording, const Run& run,
                                       const FrontendSettings& settings) {
  SensorFeed feed(recording, settings, imu_options(recording),
                  read_masks(settings.mask, recording.cameras), {});
  EstimatedBiases biases(run);
  std::vector<TrackedImages> all;
  while (const auto item = feed.next()) {
    const auto* tracked = std::get_if<TrackedFrame>(&*item);
    if (tracked == nullptr) continue;
    all.push_back(tracked_images(tracked->frame));
    feed.note_bias(biases.at(tracked->frame.time));
  }
  return all;
}

}  // namespace chasles
