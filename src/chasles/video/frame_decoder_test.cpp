#include <algorithm>
#include <cstdlib>

#include <gtest/gtest.h>

#include <chasles/recording/testing.hpp>
#include <chasles/video/frame_decoder.hpp>
#include <chasles/video/picture_testing.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::moving_pictures;
using test::VideoForm;
using test::VideoWriter;

FrameDecoder decoder_of(const fs::path& file) {
  std::vector<std::string> remarks;
  return FrameDecoder(std::make_shared<const VideoIndex>(read_video_index(file, remarks)));
}

FrameDecoder written_video(const std::vector<ImageFrame>& pictures, const VideoForm& form = {}) {
  const fs::path file = test::scratch() / "walk.mp4";
  VideoWriter::write(file, pictures, form);
  return decoder_of(file);
}

int worst(const GrayImage& a, const GrayImage& b) {
  if (a.width != b.width || a.height != b.height) return 256;
  int most = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    most = std::max(most, std::abs(int{a.pixels[i]} - int{b.pixels[i]}));
  }
  return most;
}

const VideoForm kLossless{.options = "qp=0"};

TEST(FrameDecoder, ALosslessVideoOfFullRangeHasThePixelsThemselves) {
  const auto pictures = moving_pictures(20);
  FrameDecoder decoder = written_video(pictures, kLossless);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    EXPECT_EQ(worst(decoder.read(i), pictures[i].images[0]), 0) << i;
  }
}

// 220 values of luma for 256 of grey: each is at most one beside.
TEST(FrameDecoder, ALimitedRangeIsSpread) {
  const auto pictures = moving_pictures(3);
  VideoForm form = kLossless;
  form.full_range = false;
  FrameDecoder decoder = written_video(pictures, form);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    EXPECT_LE(worst(decoder.read(i), pictures[i].images[0]), 1) << i;
  }
}

TEST(FrameDecoder, TenBitsAreRoundedToEight) {
  const auto pictures = moving_pictures(3);
  for (const bool full : {true, false}) {
    const VideoForm form{.options = "qp=0", .pixels = AV_PIX_FMT_YUV420P10LE, .full_range = full};
    FrameDecoder decoder = written_video(pictures, form);
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      EXPECT_EQ(worst(decoder.read(i), pictures[i].images[0]), 0) << full << i;
    }
  }
}

TEST(FrameDecoder, TheOtherCodecsAreDecoded) {
  const auto pictures = moving_pictures(20);
  FrameDecoder hevc =
      written_video(pictures, {.encoder = "libx265", .options = "crf=4", .full_range = true});
  const VideoForm jpeg{.encoder = "mjpeg",
                       .options = "flags=+qscale:global_quality=118",
                       .pixels = AV_PIX_FMT_YUVJ420P,
                       .b_pictures = 0};
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    EXPECT_LE(worst(hevc.read(i), pictures[i].images[0]), 12) << i;
  }
  FrameDecoder mjpeg = written_video(pictures, jpeg);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    EXPECT_LE(worst(mjpeg.read(i), pictures[i].images[0]), 12) << i;
  }
}

// In any order, each picture has the bytes that a pass from the start gives.
TEST(FrameDecoder, AnyOrderGivesTheSameBytes) {
  const auto pictures = moving_pictures(40);
  for (const char* encoder : {"libx264", "libx265"}) {
    FrameDecoder decoder = written_video(pictures, {.encoder = encoder});
    std::vector<GrayImage> straight;
    for (std::size_t i = 0; i < pictures.size(); ++i) straight.push_back(decoder.read(i));
    const auto expect_same = [&](std::size_t i) {
      EXPECT_EQ(decoder.read(i).pixels, straight[i].pixels) << encoder << i;
    };
    for (std::size_t i = pictures.size(); i-- > 0;) expect_same(i);
    for (std::size_t i = 0; i < pictures.size(); i += 3) expect_same(i);
    for (std::size_t i = 0; i < 100; ++i) expect_same(17 * i % pictures.size());
    expect_same(5);
    expect_same(5);
  }
}

// The first bytes of picture 12 are overwritten; key pictures are 0, 8, 16.
TEST(FrameDecoder, ADamagedPictureAndThoseAfterItAreErrorsUntilTheNextKeyPicture) {
  const auto pictures = moving_pictures(24);
  for (const char* encoder : {"libx264", "libx265"}) {
    const fs::path file = test::scratch() / "walk.mp4";
    VideoWriter::write(file, pictures, {.encoder = encoder, .b_pictures = 0});
    FrameDecoder whole = decoder_of(file);
    std::string bytes = test::slurp(file);
    const std::size_t at = test::position_of_packet(file, 12);
    for (std::size_t i = 0; i < 8; ++i) bytes[at + i] = '\xff';
    const fs::path damaged_file = file.parent_path() / "damaged.mp4";
    test::spill(damaged_file, bytes);
    FrameDecoder damaged = decoder_of(damaged_file);
    std::vector<std::size_t> lost;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      try {
        EXPECT_EQ(damaged.read(i).pixels, whole.read(i).pixels) << encoder << i;
      } catch (const InputError& error) {
        test::expect_parts(error.what(), {"damaged.mp4: the picture at ", "is damaged"});
        lost.push_back(i);
      }
    }
    EXPECT_EQ(lost, (std::vector<std::size_t>{12, 13, 14, 15})) << encoder;
  }
}

TEST(FrameDecoder, OtherFormsOfPixelsAreErrorsWithWhatToDo) {
  FrameDecoder decoder = written_video(
      moving_pictures(2),
      {.encoder = "libx264rgb", .options = "qp=0", .pixels = AV_PIX_FMT_RGB24, .b_pictures = 0});
  test::expect_parts(test::input_error([&] { decoder.read(0); }),
                     {"the picture at 0.000000 s: its pixels are gbrp", "-pix_fmt yuv420p"});
}

// Pictures before 0 are in the file, and an edit list cuts them: the first one that is shown is in
// the middle of a group.
TEST(FrameDecoder, AnEditListCutsPicturesThatOthersArePredictedFrom) {
  auto pictures = moving_pictures(20);
  const Time zero = pictures[5].time;
  for (ImageFrame& picture : pictures) picture.time -= zero;
  FrameDecoder decoder = written_video(pictures, kLossless);
  ASSERT_EQ(decoder.index().pictures.size(), 15u);
  for (std::size_t i = 0; i < 15; ++i) {
    EXPECT_EQ(decoder.index().pictures[i].time, pictures[5 + i].time) << i;
    EXPECT_EQ(worst(decoder.read(i), pictures[5 + i].images[0]), 0) << i;
  }
}

TEST(FrameDecoder, OddSizesAreRead) {
  const auto pictures = moving_pictures(4, 62, 46);
  FrameDecoder decoder = written_video(pictures, kLossless);  // 62 x 46 of 64 x 48 coded
  EXPECT_EQ(worst(decoder.read(3), pictures[3].images[0]), 0);
}

}  // namespace
}  // namespace chasles
