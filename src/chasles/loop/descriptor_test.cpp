#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <chasles/lie/testing.hpp>
#include <chasles/loop/descriptor.hpp>

namespace chasles {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// A smooth random texture as a function of the position, so that it can be seen turned and larger.
class Texture {
 public:
  explicit Texture(std::uint64_t seed) {
    test::Random random(seed);
    for (Wave& w : waves_) {
      w.k = 0.5 * random.normal_vector(2);
      w.phase = random.uniform(0, 7);
    }
  }
  double at(const Vector2d& p) const {
    double sum = 0;
    for (const Wave& w : waves_) sum += std::sin(w.k.dot(p) + w.phase);
    return 128 + 15 * sum;
  }
  // A pixel of the image is at texture_d_image (pixel - centre).
  GrayImage seen(const Matrix2d& texture_d_image) const {
    GrayImage image{.width = 161, .height = 121, .pixels = {}};
    for (int v = 0; v < image.height; ++v) {
      for (int u = 0; u < image.width; ++u) {
        const double value = at(texture_d_image * (Vector2d(u, v) - kCentre));
        image.pixels.push_back(
            static_cast<std::uint8_t>(std::lround(std::min(std::max(value, 0.0), 255.0))));
      }
    }
    return image;
  }
  static inline const Vector2d kCentre{80, 60};

 private:
  struct Wave {
    Vector2d k;
    double phase = 0;
  };
  std::array<Wave, 20> waves_;
};

Matrix2d turned(double angle, double scale) {
  Matrix2d A;
  A << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  return scale * A;
}

// How the patch at the centre of an image of the texture looks with the texture's own axes.
Descriptor upright(const Texture& texture, const Matrix2d& texture_d_image) {
  Describer describer;
  const ImagePatch patch{.centre = Texture::kCentre, .step = texture_d_image.inverse()};
  return describer.describe(texture.seen(texture_d_image), {&patch, 1}).front().value();
}

TEST(Descriptor, IsTheSameFromATurnedOrLargerImage) {
  const Texture texture(1);
  const Descriptor plain = upright(texture, Matrix2d::Identity());
  for (const double angle : {0.3, 1.6, 3.0}) {
    for (const double scale : {0.5, 0.8, 1.0}) {
      EXPECT_LT(hamming_distance(plain, upright(texture, turned(angle, scale))), 16)
          << angle << " " << scale;
    }
  }
  // Compared with what turns with the image.
  Describer describer;
  const ImagePatch still{.centre = Texture::kCentre, .step = Matrix2d::Identity()};
  const auto other = describer.describe(texture.seen(turned(1.6, 1)), {&still, 1});
  EXPECT_GT(hamming_distance(plain, other.front().value()), 80);
}

TEST(Descriptor, OfOtherPlacesDiffersAsByChance) {
  double sum = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    sum += hamming_distance(upright(Texture(2 * seed), Matrix2d::Identity()),
                            upright(Texture(2 * seed + 1), Matrix2d::Identity()));
  }
  EXPECT_NEAR(sum / 20, 128, 20);
}

TEST(Descriptor, ManyAreThoseOfEachAlone) {
  const GrayImage image = Texture(3).seen(Matrix2d::Identity());
  std::vector<ImagePatch> patches;
  for (int i = 0; i < 30; ++i) {
    patches.push_back({.centre = {25.0 + 3.7 * i, 25.0 + 2.3 * i}, .step = turned(0.1 * i, 1)});
  }
  Describer describer;
  const auto together = describer.describe(image, patches);
  for (std::size_t i = 0; i < patches.size(); ++i) {
    EXPECT_EQ(together[i], describer.describe(image, {&patches[i], 1}).front()) << i;
  }
}

TEST(Descriptor, APatchThatIsNotInsideTheImageHasNone) {
  const GrayImage image = Texture(4).seen(Matrix2d::Identity());
  const double nan = std::nan("");
  const std::vector<ImagePatch> patches{{.centre = {10, 60}, .step = Matrix2d::Identity()},
                                        {.centre = {80, 60}, .step = 4 * Matrix2d::Identity()},
                                        {.centre = {nan, 60}, .step = Matrix2d::Identity()},
                                        {.centre = {80, 60}, .step = nan * Matrix2d::Identity()},
                                        {.centre = {80, 60}, .step = Matrix2d::Identity()}};
  Describer describer;
  const auto found = describer.describe(image, patches);
  for (std::size_t i = 0; i + 1 < found.size(); ++i) EXPECT_FALSE(found[i]) << i;
  EXPECT_TRUE(found.back());
  EXPECT_FALSE(describer.describe({}, patches).back());
}

}  // namespace
}  // namespace chasles
