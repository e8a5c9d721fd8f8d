#include <cmath>

#include <gtest/gtest.h>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/frontend/frontend_testing.hpp>

namespace chasles::test {
namespace {

GrayImage plain(std::uint8_t grey) {
  return {.width = 752, .height = 480, .pixels = std::vector<std::uint8_t>(752 * 480, grey)};
}

/// A front end after the first frame of a walk.
class FrontendInput : public ::testing::Test {
 protected:
  FrontendInput() { frontend.process(frame(0)); }

  ImageFrame frame(int k) const {
    return render_frame(room(), rig, walk_pose(k), from_seconds(1 + 0.05 * k));
  }
  ImageFrame frame(int k, GrayImage first) const {
    return {.time = from_seconds(1 + 0.05 * k), .images = {std::move(first), plain(128)}};
  }
  FeatureFrame process(ImageFrame images, int last, int now) {
    return frontend.process(images, gyroscope(walk_pose(last), walk_pose(now)));
  }

  template <typename ErrorType>
  void expect_rejected(const ImageFrame& images, const RotationPrior& prior,
                       const std::vector<std::string>& parts) {
    try {
      frontend.process(images, prior);
      ADD_FAILURE() << "expected an error: " << parts[0];
    } catch (const ErrorType& error) {
      for (const std::string& part : parts) {
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
      }
    }
    frontend.process(frame(1), gyroscope(walk_pose(0), walk_pose(1)));
    EXPECT_GT(frontend.report().tracked, 120) << "the state must not change";
  }

  std::vector<Camera> rig = euroc_rig();
  Frontend frontend{FrontendSettings{}, rig};
};

TEST_F(FrontendInput, WithoutAnImageTracksWaitAndAreFoundAgain) {
  // black, saturated, missing: the rotation is accumulated meanwhile.
  for (const auto& [k, image] : {std::pair{1, plain(0)}, {2, plain(255)}, {3, GrayImage{}}}) {
    EXPECT_TRUE(process(frame(k, image), k - 1, k).pixels.empty());
    EXPECT_EQ(frontend.report().lost() + frontend.report().added, 0);
    EXPECT_EQ(frontend.report().black_images, k == 1 ? 1 : 0);
    EXPECT_EQ(frontend.report().saturated_images, k == 2 ? 1 : 0);
    EXPECT_EQ(frontend.report().missing_images, k == 3 ? 1 : 0);
  }
  process(frame(4), 3, 4);
  EXPECT_GT(frontend.report().tracked, 110);
}

TEST_F(FrontendInput, TracksThatWaitTooLongEnd) {
  for (int k = 1; k <= 11; ++k) process(frame(k, {}), k - 1, k);  // longer than max_gap
  EXPECT_EQ(frontend.report().lost_waiting, 150);
  process(frame(12), 11, 12);
  EXPECT_EQ(frontend.report().tracked, 0);
  EXPECT_EQ(frontend.report().added, 150);
}

TEST_F(FrontendInput, ABlackFirstImageIsNoBeginning) {
  Frontend fresh({}, rig);
  EXPECT_TRUE(fresh.process(frame(0, plain(2))).pixels.empty());
  EXPECT_EQ(fresh.report().added, 0);
  EXPECT_GT(fresh.process(frame(1)).pixels.size(), 150U);
}

TEST_F(FrontendInput, AGreyWallHasNoCornersAndEndsTheTracks) {
  const FeatureFrame features = process(frame(1, plain(120)), 0, 1);
  EXPECT_TRUE(features.pixels.empty());
  EXPECT_EQ(frontend.report().lost_klt, 150 - frontend.report().lost_left_image);
}

TEST_F(FrontendInput, WithoutTheOtherImageThereAreTracksOfTheFirst) {
  for (const GrayImage& other : {GrayImage{}, plain(0), plain(120)}) {
    Frontend fresh({}, rig);
    ImageFrame images = frame(0);
    images.images[1] = other;
    EXPECT_EQ(fresh.process(images).pixels.size(), 150U);
    EXPECT_EQ(fresh.report().stereo_matched, 0);
    EXPECT_GT(fresh.process(frame(1)).pixels.size(), 150U);
  }
}

TEST_F(FrontendInput, ARepeatedImageIsAStaticRig) {
  const FeatureFrame first = frontend.process(frame(1), gyroscope(walk_pose(0), walk_pose(1)));
  ImageFrame again = frame(1);
  again.time = from_seconds(1.1);
  const FeatureFrame second = frontend.process(again, {.trusted = true});
  EXPECT_GE(frontend.report().tracked, 149);
  EXPECT_LT(frontend.report().median_parallax, 0.01);
  EXPECT_LT(frontend.report().rotation_correction, 1e-5);
}

TEST_F(FrontendInput, NoiseAloneIsNotFollowed) {
  Random random(5);
  for (int k = 1; k <= 3; ++k) {
    ImageFrame noise = frame(k, plain(0));
    for (std::uint8_t& v : noise.images[0].pixels) v = static_cast<std::uint8_t>(random.next());
    frontend.process(noise, {.trusted = true});
    EXPECT_LT(frontend.report().tracked, 10);
  }
}

TEST_F(FrontendInput, ATimeThatDoesNotRiseIsRejected) {
  expect_rejected<InputError>(frame(0), {}, {"time", "1000000000 ns", "rising"});
  ImageFrame early = frame(2);
  early.time = from_seconds(0.5);
  Frontend fresh({}, rig);
  fresh.process(frame(1));
  EXPECT_THROW(fresh.process(early), InputError);
}

TEST_F(FrontendInput, AnImageOfAnotherSizeIsRejected) {
  ImageFrame wrong = frame(1);
  wrong.images[1] = {.width = 640, .height = 480, .pixels = std::vector<std::uint8_t>(640 * 480)};
  expect_rejected<InputError>(wrong, {}, {"camera 1", "640 x 480", "752 x 480"});
}

TEST_F(FrontendInput, ImagesShortOfPixelsAreRejected) {
  ImageFrame wrong = frame(1);
  wrong.images[0].pixels.pop_back();
  expect_rejected<InputError>(wrong, {}, {"camera 0", "360959 bytes"});
}

TEST_F(FrontendInput, AnotherNumberOfImagesThanCamerasIsRejected) {
  ImageFrame wrong = frame(1);
  wrong.images.pop_back();
  expect_rejected<InputError>(wrong, {}, {"found 1 images", "expected 2"});
}

TEST_F(FrontendInput, AMatrixThatIsNoRotationIsRejected) {
  RotationPrior prior{.trusted = true};
  prior.now_R_last_imu(1, 2) = kNaN;
  expect_rejected<InputError>(frame(1), prior, {"rotation", "NaN"});
  prior.now_R_last_imu = -Eigen::Matrix3d::Identity();
  EXPECT_THROW(frontend.process(frame(2), prior), InputError);
  prior.now_R_last_imu = 1.01 * Eigen::Matrix3d::Identity();
  EXPECT_THROW(frontend.process(frame(2), prior), InputError);
}

TEST(FrontendSetup, UnusableCamerasAndMasksAreNamed) {
  const std::vector<Camera> rig = euroc_rig();
  EXPECT_THROW(Frontend({}, {}), UsageError);
  EXPECT_THROW(Frontend({.window = 8}, rig), UsageError);
  EXPECT_THROW(Frontend({}, rig, {plain(255)}), UsageError);
  EXPECT_NO_THROW(Frontend({}, rig, {plain(255), GrayImage{}}));
  EXPECT_THROW(Frontend({}, rig, {GrayImage{}, {.width = 3, .height = 1, .pixels = {1, 1, 1}}}),
               UsageError);
  for (const int field : {0, 1, 2, 3}) {
    std::vector<Camera> bad = rig;
    if (field == 0) bad[1].fx = 0;
    if (field == 1) bad[1].width = 20;
    if (field == 2) bad[1].coefficients[2] = kNaN;
    if (field == 3) bad[1].cam_T_imu.p[0] = kNaN;
    EXPECT_THROW(Frontend({}, bad), UsageError);
  }
}

TEST(FrontendSetup, SmallImagesAndBigGridsWork) {
  Camera camera = euroc_camera();
  camera.width = 60;
  camera.height = 50;
  camera.cx = 30;
  camera.cy = 25;
  Frontend frontend({.grid_columns = 100, .grid_rows = 100}, {camera});
  for (int k = 0; k < 3; ++k) {
    frontend.process(render_frame(room(), {camera}, walk_pose(k), from_seconds(1 + k)));
    EXPECT_LE(frontend.report().added + frontend.report().tracked, 20);
  }
}

}  // namespace
}  // namespace chasles::test
