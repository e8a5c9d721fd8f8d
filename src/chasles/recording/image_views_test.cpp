#include <gtest/gtest.h>

#include <chasles/recording/image_views.hpp>

namespace chasles {
namespace {

/// Frames at 0, 10, 20, … of two cameras; the first camera's only pixel is the frame's number.
class Numbered : public ImageSource {
 public:
  std::size_t size() const override { return 5; }
  Time time(std::size_t i) const override { return Time(10 * static_cast<int>(i)); }
  ImageFrame read(std::size_t i) const override {
    const auto number = static_cast<std::uint8_t>(i);
    return {.time = time(i), .images = {{1, 1, {number}}, {1, 1, {100}}}};
  }
};

TEST(PartOfImages, HasTheFramesOfItsTimeWithTheirImages) {
  const auto part = part_of(std::make_shared<Numbered>(), Time(5), Time(30), 2);
  ASSERT_EQ(part->size(), 3u);
  EXPECT_EQ(part->time(0), Time(10));
  EXPECT_EQ(part->time(2), Time(30));
  const ImageFrame last = part->read(2);
  EXPECT_EQ(last.time, Time(30));
  ASSERT_EQ(last.images.size(), 2u);
  EXPECT_EQ(last.images[0].pixels[0], 3);
}

TEST(PartOfImages, HasTheFirstCamerasAlone) {
  const auto mono = part_of(std::make_shared<Numbered>(), Time(0), Time(100), 1);
  EXPECT_EQ(mono->size(), 5u);
  ASSERT_EQ(mono->read(4).images.size(), 1u);
  EXPECT_EQ(mono->read(4).images[0].pixels[0], 4);
}

TEST(PartOfImages, MayBeEmpty) {
  EXPECT_EQ(part_of(std::make_shared<Numbered>(), Time(41), Time(100), 2)->size(), 0u);
  EXPECT_EQ(part_of(std::make_shared<Numbered>(), Time(30), Time(10), 2)->size(), 0u);
}

}  // namespace
}  // namespace chasles
