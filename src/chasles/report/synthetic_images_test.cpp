#include <array>

#include <chasles/codec/image_encode.hpp>
#include <chasles/report/testing.hpp>

namespace chasles::test {
namespace {

constexpr int kWidth = 192, kHeight = 120, kPoints = 12;  // [px], of the camera

// Stripes that move with the frame.
std::string picture(int frame) {
  GrayImage image{.width = kWidth, .height = kHeight, .pixels = {}};
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      image.pixels.push_back(static_cast<std::uint8_t>(60 + 2 * ((u + 7 * frame + v) % 64)));
    }
  }
  return jpeg_bytes(image, kWidth / 2);
}

ImageFeature feature(int id, int camera, int frame) {
  const Eigen::Vector2d pixel(10 + 14 * id + 0.25 * (frame % 20), 12 + 8 * id);
  ImageFeature f{.seen = {.observation = {.landmark = id, .camera = camera, .pixel = pixel},
                          .outcome = static_cast<Outcome>(id % 4)},
                 .age = frame + 1};
  if (frame > 0) f.before = pixel - Eigen::Vector2d(6, 1.5);
  if (f.seen.outcome != Outcome::kUsed && f.seen.outcome != Outcome::kRejected) return f;
  const double far = f.seen.outcome == Outcome::kUsed ? 0.5 : 9;
  f.seen.expected =
      ExpectedPixel{.pixel = pixel + Eigen::Vector2d(far, -far),
                    .covariance = (Eigen::Matrix2d() << 1.5, 0.4, 0.4, 0.75).finished()};
  return f;
}

}  // namespace

void add_synthetic_images(Run& run, int every) {
  for (std::size_t i = 0; i < run.states.size(); i += static_cast<std::size_t>(every)) {
    const int frame = static_cast<int>(i) / every;
    for (const int camera : {0, 1}) {
      run.images.push_back({.time = run.states[i].time,
                            .camera = camera,
                            .width = kWidth,
                            .height = kHeight,
                            .jpeg = camera == 0 ? picture(frame) : "",
                            .features = {}});
      for (int id = 0; id < kPoints; ++id) {
        run.images.back().features.push_back(feature(id, camera, frame));
      }
    }
  }
}

}  // namespace chasles::test
