#include <cmath>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <chasles/frontend/deformation.hpp>
#include <chasles/frontend/follow.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles::test {
namespace {

/// A smooth picture with texture everywhere, at x, y.
double picture(double x, double y) {
  return 128 + 40 * std::sin(0.35 * x + 0.1 * y) + 35 * std::sin(0.3 * y - 0.15 * x + 1) +
         20 * std::sin(0.21 * (x + y));
}

/// gain * picture + offset with the content moved by `shift` pixels.
template <typename Function>
ImagePyramid image_of(Function grey, int levels = 1) {
  GrayImage image{.width = 120, .height = 90, .pixels = {}};
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double value = std::min(255.0, std::max(0.0, grey(x, y)));
      image.pixels.push_back(static_cast<std::uint8_t>(std::lround(value)));
    }
  }
  ImagePyramid pyramid;
  build_pyramid(image, Equalisation::kNone, levels, pyramid);
  return pyramid;
}

ImagePyramid moved(const Eigen::Vector2d& shift, double gain, double offset) {
  return image_of([=](double x, double y) {
    return 128 + gain * (picture(x - shift.x(), y - shift.y()) - 128) + offset;
  });
}

const Eigen::Vector2f kCentre(60.3F, 45.7F);

class PatchOfSide : public ::testing::TestWithParam<int> {};

TEST_P(PatchOfSide, IsFoundToATwentiethOfAPixelWhateverTheGainAndOffset) {
  const ImagePyramid first = moved({0, 0}, 1, 0);
  Patch patch;
  ASSERT_TRUE(make_patch(first.levels[0], kCentre, PatchShape{}, GetParam(), 1, patch));
  for (const Eigen::Vector2d& shift : {Eigen::Vector2d(0, 0), Eigen::Vector2d(1.25, -0.6),
                                       Eigen::Vector2d(-2.4, 1.7), Eigen::Vector2d(0.5, 0.5)}) {
    for (const auto& [gain, offset] : {std::pair{1.0, 0.0}, {0.6, 20.0}, {1.15, -12.0}}) {
      const ImagePyramid other = moved(shift, gain, offset);
      const auto found = align(patch, other.levels[0], kCentre, 20, 0.005F);
      ASSERT_TRUE(found);
      EXPECT_LT((found->centre.cast<double>() - kCentre.cast<double>() - shift).norm(), 0.05)
          << shift.transpose() << ", gain " << gain;
      EXPECT_GT(found->correlation, 0.99F);
      EXPECT_LE(found->correlation, 1.0F);
      EXPECT_NEAR(correlation(patch, other.levels[0], found->centre), found->correlation, 1e-3);
    }
  }
}

TEST_P(PatchOfSide, IsFoundInATurnedImageIfBentAlike) {
  const ImagePyramid first = moved({0, 0}, 1, 0);
  const double angle = 0.6;
  Eigen::Matrix2d now_R_last;
  now_R_last << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  const Eigen::Vector2d centre = kCentre.cast<double>();
  const ImagePyramid turned = image_of([&](double x, double y) {
    const Eigen::Vector2d p = centre + now_R_last.transpose() * (Eigen::Vector2d(x, y) - centre);
    return picture(p.x(), p.y());
  });
  Patch bent, straight;
  const Eigen::Matrix2f last_A_now = now_R_last.transpose().cast<float>();
  ASSERT_TRUE(make_patch(first.levels[0], kCentre, last_A_now, GetParam(), 1, bent));
  ASSERT_TRUE(make_patch(first.levels[0], kCentre, PatchShape{}, GetParam(), 1, straight));
  const Eigen::Vector2f start = kCentre + Eigen::Vector2f(0.8F, -0.7F);
  const auto found = align(bent, turned.levels[0], start, 20, 0.005F);
  ASSERT_TRUE(found);
  EXPECT_LT((found->centre - kCentre).norm(), 0.05F);
  EXPECT_GT(found->correlation, 0.99F);
  EXPECT_LT(correlation(straight, turned.levels[0], kCentre), 0.8F);
}

// Lines of the first image are parabolas in the second one.
TEST_P(PatchOfSide, IsFoundWhereItsLinesAreBowed) {
  const ImagePyramid first = moved({0, 0}, 1, 0);
  const Eigen::Vector2d centre = kCentre.cast<double>();
  const ImagePyramid bowed = image_of([&](double x, double y) {
    const Eigen::Vector2d o = Eigen::Vector2d(x, y) - centre;
    const Eigen::Vector2d p =
        centre + o +
        Eigen::Vector2d(0.008 * o.y() * o.y(), 0.006 * o.x() * o.x() + 0.005 * o.x() * o.y());
    return picture(p.x(), p.y());
  });
  PatchShape shape;
  shape.bow << 0, 0, 0.008F, 0.006F, 0.005F, 0;
  Patch curved, straight;
  ASSERT_TRUE(make_patch(first.levels[0], kCentre, shape, GetParam(), 1, curved));
  ASSERT_TRUE(make_patch(first.levels[0], kCentre, PatchShape{}, GetParam(), 1, straight));
  const Eigen::Vector2f start = kCentre + Eigen::Vector2f(0.4F, -0.3F);
  const auto found = align(curved, bowed.levels[0], start, 20, 0.005F);
  ASSERT_TRUE(found);
  EXPECT_LT((found->centre - kCentre).norm(), 0.05F);
  EXPECT_GT(found->correlation, 0.99F);
  const auto biased = align(straight, bowed.levels[0], start, 20, 0.005F);
  if (GetParam() < 11) return;
  EXPECT_TRUE(!biased || (biased->centre - kCentre).norm() > 0.1F);
}

// The sums of the products are the largest that there are.
TEST_P(PatchOfSide, OfBlackAndWhitePixelsFitsItself) {
  const ImagePyramid image = image_of([](double x, double y) {
    const auto i = static_cast<unsigned>(x), j = static_cast<unsigned>(y);
    return ((i * 2654435761U ^ j * 2246822519U) >> 13 & 1U) != 0 ? 255.0 : 0.0;
  });
  const Eigen::Vector2f centre(60, 45);
  Patch patch;
  ASSERT_TRUE(make_patch(image.levels[0], centre, PatchShape{}, GetParam(), 1, patch));
  EXPECT_GT(patch.energy, 0.9 * 127 * 127 * Patch::kUnit * Patch::kUnit * GetParam() * GetParam());
  EXPECT_GT(correlation(patch, image.levels[0], centre), 0.999F);
  const auto found = align(patch, image.levels[0], centre, 20, 0.005F);
  ASSERT_TRUE(found);
  EXPECT_LT((found->centre - centre).norm(), 0.01F);
}

class BendOfSide : public PatchOfSide {};

// Repeated, down to the error of the interpolation between pixels.
TEST_P(BendOfSide, LearnsHowTheImageIsBentUnderIt) {
  const ImagePyramid first = moved({0, 0}, 1, 0);
  const Eigen::Vector2d centre = kCentre.cast<double>(), shift(0.2, -0.15);
  Eigen::Matrix2d bend;
  for (const Eigen::Vector4d& b : {Eigen::Vector4d(0, 0, 0, 0), Eigen::Vector4d(0.05, 0, 0, 0.05),
                                   Eigen::Vector4d(-0.05, 0.03, -0.04, 0.03)}) {
    bend << b[0], b[1], b[2], b[3];
    const Eigen::Matrix2d back = (Eigen::Matrix2d::Identity() + bend).inverse();
    const ImagePyramid bent = image_of([&](double x, double y) {
      const Eigen::Vector2d p = centre + back * (Eigen::Vector2d(x, y) - centre - shift);
      return 20 + 0.8 * picture(p.x(), p.y());
    });
    Expectation expected{.from = centre, .to = centre};
    for (int pass = 0; pass < 10; ++pass) {
      const auto found = find_again(first, bent, expected, {.window = GetParam()});
      ASSERT_TRUE(found);
      expected.to = found->pixel;
      expected.to_A_from = found->to_A_from;
    }
    EXPECT_LT((expected.to - centre - shift).norm(), 0.02) << bend;
    EXPECT_LT((expected.to_A_from - bend - Eigen::Matrix2d::Identity()).cwiseAbs().maxCoeff(), 0.01)
        << bend;
  }
  Patch patch;
  ASSERT_TRUE(make_patch(first.levels[0], kCentre, PatchShape{}, GetParam(), 1, patch));
  EXPECT_FALSE(deformation(patch, first.levels[0], {-1, 40}));
  EXPECT_FALSE(deformation(patch, image_of([](double, double) { return 77.0; }).levels[0], kCentre))
      << "no patch there, so no gain";
}

INSTANTIATE_TEST_SUITE_P(Sides, PatchOfSide, ::testing::Values(7, 15, 17, 21, 23));
INSTANTIATE_TEST_SUITE_P(Sides, BendOfSide, ::testing::Values(15, 17, 23));

TEST(Patch, WithoutTwoDirectionsOfTextureIsNone) {
  Patch patch;
  const auto make = [&](const ImagePyramid& image) {
    return make_patch(image.levels[0], kCentre, PatchShape{}, 15, 1, patch);
  };
  EXPECT_FALSE(make(image_of([](double, double) { return 77.0; })));
  EXPECT_FALSE(make(image_of([](double x, double) { return 128 + 100 * std::sin(0.4 * x); })));
  EXPECT_TRUE(make(image_of(picture)));
}

TEST(Patch, OutsideTheImageIsNoneAndThatLeavesItIsNotFound) {
  const ImagePyramid image = moved({0, 0}, 1, 0);
  Patch patch;
  const Eigen::Matrix2f I = Eigen::Matrix2f::Identity();
  for (const Eigen::Vector2f& outside :
       {Eigen::Vector2f(-1, 40), Eigen::Vector2f(40, -0.1F), Eigen::Vector2f(119.5F, 40),
        Eigen::Vector2f(40, 89.5F), Eigen::Vector2f(std::nanf(""), 40)}) {
    EXPECT_FALSE(make_patch(image.levels[0], outside, I, 15, 1, patch));
  }
  ASSERT_TRUE(make_patch(image.levels[0], {2, 45}, I, 23, 1, patch));
  EXPECT_FALSE(align(patch, image.levels[0], {-3, 45}, 10, 0.01F));
  const ImagePyramid gone = moved({-6, 0}, 1, 0);
  EXPECT_FALSE(align(patch, gone.levels[0], {1, 45}, 10, 0.01F));
}

TEST(Patch, InTheCornersOfTheImageIsReadFromThePadding) {
  const ImagePyramid image = moved({0, 0}, 1, 0);
  for (const Eigen::Vector2f& corner : {Eigen::Vector2f(0, 0), Eigen::Vector2f(119, 0),
                                        Eigen::Vector2f(0, 89), Eigen::Vector2f(119, 89)}) {
    Patch patch;
    ASSERT_TRUE(make_patch(image.levels[0], corner, PatchShape{}, 23, 0, patch));
    EXPECT_GT(correlation(patch, image.levels[0], corner), 0.999F);
    Eigen::Matrix2f stretched = 2.5F * Eigen::Matrix2f::Identity();
    EXPECT_TRUE(make_patch(image.levels[0], corner, stretched, 23, 0, patch));
  }
}

}  // namespace
}  // namespace chasles::test
