#include <cmath>

#include <chasles/base/constants.hpp>
#include <chasles/reconstruct/undistortion.hpp>

namespace chasles {
namespace {

Camera pinhole_of(Camera camera) {
  const Eigen::Vector2d focal = focal_lengths_at_axis(camera);
  camera.fx = focal.x();
  camera.fy = focal.y();
  camera.distortion = Distortion::kNone;
  camera.coefficients = {};
  return camera;
}

std::uint8_t bilinear(const GrayImage& image, const Eigen::Vector2f& at) {
  const float x0 = std::floor(at.x()), y0 = std::floor(at.y());
  const float x = at.x() - x0, y = at.y() - y0;
  const auto* above = image.pixels.data() + static_cast<std::ptrdiff_t>(y0) * image.width +
                      static_cast<std::ptrdiff_t>(x0);
  const auto* below = above + image.width;
  const float grey =
      (1 - y) * ((1 - x) * static_cast<float>(above[0]) + x * static_cast<float>(above[1])) +
      y * ((1 - x) * static_cast<float>(below[0]) + x * static_cast<float>(below[1]));
  return static_cast<std::uint8_t>(std::lround(grey));
}

}  // namespace

Undistortion::Undistortion(const Camera& camera) : camera_(camera), pinhole_(pinhole_of(camera)) {
  const Eigen::Vector2f none = Eigen::Vector2f::Constant(static_cast<float>(kNaN));
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const auto ray = unproject(pinhole_, {u, v});
      const auto seen = ray ? project(camera_, ray->ray) : std::nullopt;
      // The neighbours on the right and below are in the image, too.
      const bool inside = seen && seen->pixel.x() >= 0 && seen->pixel.y() >= 0 &&
                          seen->pixel.x() < camera.width - 1 && seen->pixel.y() < camera.height - 1;
      from_.push_back(inside ? Eigen::Vector2f(seen->pixel.cast<float>()) : none);
    }
  }
}

std::optional<Eigen::Vector2d> Undistortion::pixel(const Eigen::Vector2d& distorted) const {
  const auto ray = unproject(camera_, distorted);
  const auto seen = ray ? project(pinhole_, ray->ray) : std::nullopt;
  if (!seen || !in_image(pinhole_, seen->pixel)) return std::nullopt;
  return seen->pixel;
}

GrayImage Undistortion::image(const GrayImage& distorted) const {
  GrayImage image{.width = camera_.width, .height = camera_.height, .pixels = {}};
  image.pixels.reserve(from_.size());
  for (const Eigen::Vector2f& at : from_) {
    image.pixels.push_back(at.allFinite() ? bilinear(distorted, at) : std::uint8_t{0});
  }
  return image;
}

}  // namespace chasles
