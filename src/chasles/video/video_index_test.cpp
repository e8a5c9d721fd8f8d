#include <cmath>

#include <gtest/gtest.h>

#include <chasles/recording/testing.hpp>
#include <chasles/video/libav.hpp>
#include <chasles/video/picture_testing.hpp>
#include <chasles/video/video_index.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;
using test::moving_pictures;
using test::VideoForm;
using test::VideoWriter;

struct Scanned {
  VideoIndex index;
  std::vector<std::string> remarks;
};

Scanned scan(const fs::path& file) {
  Scanned scanned;
  scanned.index = read_video_index(file, scanned.remarks);
  return scanned;
}

fs::path written(const VideoForm& form = {}, int count = 20) {
  const fs::path file = test::scratch() / "walk.mp4";
  VideoWriter::write(file, moving_pictures(count), form);
  return file;
}

std::string error_of(const fs::path& file) {
  return input_error([&] { scan(file); });
}

std::string bytes_of(const fs::path& file) { return test::slurp(file); }

TEST(VideoIndex, TimesAreThoseOfTheFileInTheOrderOfDisplay) {
  const auto pictures = moving_pictures(20);
  for (const int b_pictures : {0, 2}) {
    const auto [index, remarks] = scan(written({.b_pictures = b_pictures}));
    EXPECT_EQ(index.codec, "h264");
    EXPECT_EQ(index.width, 64);
    EXPECT_EQ(index.height, 48);
    ASSERT_EQ(index.pictures.size(), pictures.size());
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      EXPECT_EQ(index.pictures[i].time, pictures[i].time) << i;  // ms are whole ticks of 90 kHz
    }
    EXPECT_EQ(index.keys.size(), 3u);
    EXPECT_TRUE(remarks.empty()) << remarks.front();
  }
}

TEST(VideoIndex, AFileWithItsIndexFirstAndOtherCodecsAreRead) {
  EXPECT_EQ(scan(written({.index_first = true})).index.pictures.size(), 20u);
  EXPECT_EQ(scan(written({.encoder = "libx265"})).index.codec, "hevc");
  const VideoForm jpeg{.encoder = "mjpeg", .pixels = AV_PIX_FMT_YUVJ420P, .b_pictures = 0};
  EXPECT_EQ(scan(written(jpeg)).index.codec, "mjpeg");
  EXPECT_EQ(scan(written({.sound = true})).index.pictures.size(), 20u);
}

TEST(VideoIndex, TelemetryIsReadWithItsTimesAndOtherDataAreNot) {
  const std::vector<test::TimedBytes> telemetry{
      {.time = Time(0), .duration = Time(1'001'000'000), .bytes = "first"},
      {.time = Time(1'001'000'000), .duration = Time(500'000'000), .bytes = "and second"}};
  const fs::path file = test::scratch() / "walk.mp4";
  VideoWriter::write(file, moving_pictures(40), {}, telemetry);
  const VideoIndex index = scan(file).index;
  ASSERT_EQ(index.telemetry.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(index.telemetry[i].bytes, telemetry[i].bytes);
    EXPECT_LT(std::abs(to_seconds(index.telemetry[i].time - telemetry[i].time)), 1e-6);
  }
  EXPECT_LT(std::abs(to_seconds(index.telemetry[0].duration - telemetry[0].duration)), 1e-6);
}

TEST(VideoIndex, ATurnForPlayersIsSaid) {
  const auto [index, remarks] = scan(written({.turn = 90}));
  EXPECT_EQ(index.turn, 90);
  ASSERT_EQ(remarks.size(), 1u);
  expect_parts(remarks[0], {"turned by 90 deg clockwise", "as it is stored, 64 x 48"});
}

TEST(VideoIndex, ACutFileIsReadToItsEndAndSaysSo) {
  const fs::path file = written({.index_first = true}, 60);
  const std::string whole = bytes_of(file);
  test::spill(file, whole.substr(0, whole.size() * 3 / 4));
  const auto [index, remarks] = scan(file);
  EXPECT_GT(index.pictures.size(), 10u);
  EXPECT_LT(index.pictures.size(), 60u);
  ASSERT_EQ(remarks.size(), 1u);
  expect_parts(remarks[0], {"of 60 pictures that the video lists are not in it", "it is cut"});
}

TEST(VideoIndex, AFileWithoutItsIndexIsAnError) {
  const fs::path file = written();
  const std::string whole = bytes_of(file);
  test::spill(file, whole.substr(0, whole.size() * 3 / 4));  // the index is at its end
  expect_parts(error_of(file), {"walk.mp4: its index cannot be read", "(moov)", "copy it again"});
  test::spill(file, "");
  expect_parts(error_of(file), {"walk.mp4: its index cannot be read"});
  expect_parts(error_of(file.parent_path() / "none.mp4"), {"none.mp4"});
  expect_parts(error_of(file.parent_path()), {"folder"});
}

TEST(VideoIndex, SoundAloneAndTwoVideosAreErrors) {
  expect_parts(error_of(written({.videos = 2})), {"has 2 videos in 2 streams, expected one"});
  const fs::path file = test::scratch() / "walk.mp4";
  VideoWriter::write(file, moving_pictures(1), {.videos = 0, .sound = true});
  expect_parts(error_of(file), {"has 0 videos in 1 streams", "sound or of telemetry alone"});
}

TEST(VideoIndex, AnotherCodecIsNamedWithWhatToDo) {
  expect_parts(
      error_of(written({.encoder = "mpeg4", .full_range = false, .ticks_per_second = 30'000})),
      {"its pictures are mpeg4, expected H.264, H.265 or Motion JPEG", "ffmpeg -i"});
}

TEST(VideoIndex, AMissingLibraryIsNamedWithItsPackage) {
  expect_parts(
      input_error([] { load_libav("libavutil.so.1 libavcodec.so.1 libavformat.so.1"); }),
      {"libavutil.so.1 cannot be loaded, and videos need it", "Debian, Ubuntu: libavutil1"});
}

TEST(VideoIndex, AVideoWithoutPicturesIsAnError) {
  const fs::path file = written({.index_first = true});
  const std::string whole = bytes_of(file);
  test::spill(file, whole.substr(0, whole.find("mdat") + 6));
  expect_parts(error_of(file), {"holds no picture that can be decoded", "broke off"});
}

}  // namespace
}  // namespace chasles
