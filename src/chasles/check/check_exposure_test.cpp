#include <algorithm>
#include <functional>

#include <chasles/check/check_exposure.hpp>
#include <chasles/check/check_testing.hpp>

namespace chasles {
namespace {

using test::fact;
using test::finding;

GrayImage image_of(int first, int step) {
  GrayImage image{.width = 16, .height = 8, .pixels = {}};
  for (int i = 0; i < 128; ++i) {
    image.pixels.push_back(static_cast<std::uint8_t>(std::clamp(first + step * (i % 16), 0, 255)));
  }
  return image;
}

/// Frames from a function of their index.
class MadeImages : public ImageSource {
 public:
  using Maker = std::function<GrayImage(std::size_t)>;
  explicit MadeImages(Maker maker, std::size_t size = 40) : maker_(std::move(maker)), size_(size) {}
  std::size_t size() const override { return size_; }
  Time time(std::size_t i) const override { return std::chrono::milliseconds(50 * i); }
  ImageFrame read(std::size_t i) const override { return {.time = time(i), .images = {maker_(i)}}; }

 private:
  Maker maker_;
  std::size_t size_;
};

CheckReport report_of(const MadeImages::Maker& maker, std::size_t size = 40) {
  CheckReport report;
  report_exposure(MadeImages(maker, size), 1, 50, report);
  return report;
}

TEST(CheckExposure, SharesAreThoseOfThePixels) {
  const ImageExposure e = exposure_of(image_of(0, 17));  // 0, 17 ... 255 in equal shares
  EXPECT_DOUBLE_EQ(e.mean, 127.5);
  EXPECT_DOUBLE_EQ(e.dark, 1.0 / 16);
  EXPECT_DOUBLE_EQ(e.bright, 1.0 / 16);
  EXPECT_NEAR(e.contrast, 17 * std::sqrt((16 * 16 - 1) / 12.0), 1e-9);
}

TEST(CheckExposure, GoodImagesGiveNoFinding) {
  const CheckReport report = report_of([](std::size_t i) { return image_of(int(i) + 20, 10); });
  EXPECT_EQ(test::findings(report), "");
  EXPECT_NEAR(fact(report, "cam0", "brightness"), 20 + 75 + 19, 1);
}

TEST(CheckExposure, OfAnUnreadableCameraTheOtherIsExamined) {
  class TornSecond : public MadeImages {
   public:
    TornSecond() : MadeImages([](std::size_t i) { return image_of(int(i) + 20, 10); }) {}
    ImageFrame read_undamaged(std::size_t i, std::size_t, const OnDamage& damaged) const override {
      ImageFrame frame = read(i);
      frame.images.push_back(
          read_or_empty([]() -> GrayImage { throw InputError("torn"); }, damaged));
      return frame;
    }
  };
  CheckReport report;
  report_exposure(TornSecond(), 2, 50, report);
  EXPECT_NEAR(fact(report, "cam0", "brightness"), 20 + 75 + 19, 1);
  ASSERT_EQ(report.findings.size(), 1u);
  EXPECT_EQ(report.findings[0].what,
            "78 of the 78 frames examined have an image that cannot be read; the first: torn");
}

TEST(CheckExposure, ACameraThatMostFramesLackIsNamed) {
  class Apart : public MadeImages {
   public:
    Apart() : MadeImages([](std::size_t i) { return image_of(int(i) + 20, 10); }) {}
    ImageFrame read_undamaged(std::size_t i, std::size_t, const OnDamage&) const override {
      ImageFrame frame = read(i);
      frame.images.push_back(i % 5 == 0 ? image_of(int(i) + 20, 10) : GrayImage{});
      return frame;
    }
  };
  CheckReport report;
  report_exposure(Apart(), 2, 50, report);
  ASSERT_EQ(report.findings.size(), 1u) << test::findings(report);
  EXPECT_NEAR(finding(report, "cam1", "of the frames examined have no image of it").value, 80, 3);
}

TEST(CheckExposure, DarkBrightBlankAndFrozenImagesAreNamed) {
  finding(report_of([](std::size_t i) { return image_of(int(i % 2), 1); }), "cam0",
          "the pixels are dark");
  finding(report_of([](std::size_t i) { return image_of(150 + int(i % 2), 20); }), "cam0",
          "the pixels are saturated");
  finding(report_of([](std::size_t i) { return image_of(120 + int(i % 2), i == 7 ? 0 : 5); }),
          "cam0", "the images show nothing");
  finding(report_of([](std::size_t i) { return image_of(20 + int(i) / 10, 10); }), "cam0",
          "repeat the one before");
}

TEST(CheckExposure, DamagedImagesAreCountedAndNamed) {
  const CheckReport report = report_of([](std::size_t i) {
    if (i == 11) throw InputError("11.png: the image is damaged");
    return image_of(int(i) + 20, 10);
  });
  const Finding damaged = finding(report, "images", "11.png: the image is damaged");
  EXPECT_EQ(damaged.severity, Severity::kError);
  EXPECT_EQ(damaged.value, 2) << "as the first and as the second of a pair";
}

TEST(CheckExposure, NoneOneAndMissingImagesAreNoTrouble) {
  for (const std::size_t size : {0u, 1u}) {
    EXPECT_TRUE(report_of([](std::size_t) { return image_of(20, 10); }, size).findings.empty());
  }
  EXPECT_EQ(test::findings(report_of([](std::size_t) { return GrayImage{}; })), "");
}

}  // namespace
}  // namespace chasles
