#include <algorithm>
#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/reconstruct/undistorted_images.hpp>

namespace chasles {
namespace {

Camera fisheye() {
  return {.width = 160,
          .height = 120,
          .fx = 60,
          .fy = 61,
          .cx = 79.5,
          .cy = 59.5,
          .distortion = Distortion::kDoubleSphere,
          .coefficients = {-0.2, 0.55},
          .cam_T_imu = {}};
}

// What the camera sees of a scene whose grey value is this smooth function of the direction.
double scene(double x, double y) { return 128 + 60 * std::sin(3 * x) + 40 * std::cos(4 * y); }

GrayImage picture(const Camera& camera) {
  GrayImage image{.width = camera.width, .height = camera.height, .pixels = {}};
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const auto ray = unproject(camera, {u, v});
      const double grey = ray ? scene(ray->ray.x(), ray->ray.y()) : 0;
      image.pixels.push_back(static_cast<std::uint8_t>(std::lround(grey)));
    }
  }
  return image;
}

TEST(Undistortion, TheImageIsThatOfThePinholeCamera) {
  const Undistortion undistortion(fisheye());
  const Camera& pinhole = undistortion.pinhole();
  EXPECT_EQ(pinhole.distortion, Distortion::kNone);
  EXPECT_EQ(pinhole.cx, 79.5);
  EXPECT_NEAR(pinhole.fx, focal_lengths_at_axis(fisheye()).x(), 1e-12);
  const GrayImage found = undistortion.image(picture(fisheye())), expected = picture(pinhole);
  ASSERT_EQ(found.pixels.size(), expected.pixels.size());
  int largest = 0;
  for (std::size_t i = 0; i < found.pixels.size(); ++i) {
    largest = std::max(largest, std::abs(int{found.pixels[i]} - int{expected.pixels[i]}));
  }
  EXPECT_LE(largest, 2) << "of 256: rounding, and the curve between two pixels";
}

TEST(Undistortion, APixelIsThatOfTheSameRay) {
  const Undistortion undistortion(fisheye());
  const Eigen::Vector3d p(0.3, -0.2, 1);
  const auto at = undistortion.pixel(project(fisheye(), p).value().pixel);
  ASSERT_TRUE(at);
  EXPECT_LT((*at - project(undistortion.pinhole(), p).value().pixel).norm(), 1e-9);
  EXPECT_FALSE(undistortion.pixel({0.5, 0.5})) << "too far out for the pinhole's image";
}

TEST(Undistortion, WhereTheCameraSeesNothingItIsBlack) {
  Camera pincushion = fisheye();
  pincushion.distortion = Distortion::kRadtan;
  pincushion.coefficients = {0.2, 0, 0, 0};
  const GrayImage white{
      .width = 160, .height = 120, .pixels = std::vector<std::uint8_t>(19200, 255)};
  const GrayImage found = Undistortion(pincushion).image(white);
  EXPECT_EQ(found.pixels.front(), 0);
  EXPECT_EQ(found.pixels[60 * 160 + 80], 255);
}

// Two cameras, of which the second has no image in the first frame.
class TwoCameras : public ImageSource {
 public:
  std::size_t size() const override { return 2; }
  Time time(std::size_t i) const override { return std::chrono::seconds(i + 1); }
  ImageFrame read(std::size_t i) const override {
    ImageFrame frame{.time = time(i), .images = {picture(fisheye()), picture(fisheye())}};
    if (i == 0) frame.images[1] = {};
    return frame;
  }
  bool has_image(std::size_t i, std::size_t camera) const override { return i == 1 || camera == 0; }
};

TEST(UndistortedImages, AreMadeInTheOrderInWhichTheyAreWanted) {
  UndistortedImages images(std::make_shared<TwoCameras>(), undistortions({fisheye(), fisheye()}));
  images.want(0, 0, "a.png");
  images.want(1, 1, "b.png");
  std::vector<std::string> names;
  images.write([&](const std::string& name, const std::string& bytes) {
    names.push_back(name);
    EXPECT_TRUE(bytes.starts_with("\x89PNG"));
  });
  EXPECT_EQ(names, (std::vector<std::string>{"a.png", "b.png"}));
  images.want(0, 1, "c.png");
  EXPECT_THROW(images.write([](const std::string&, const std::string&) {}), InputError);
}

// Images that are no files, of two cameras of a calibration with more of them.
TEST(UndistortedImages, HaveThePosesOfTheRunsFirstCamera) {
  Recording recording;
  recording.name = "bag";
  recording.images = std::make_shared<TwoCameras>();
  recording.cameras = {fisheye(), fisheye()};
  recording.cameras[1].fx = 70;
  recording.camera_numbers = {2, 5};
  ReportRun run;
  run.summary = R"({"cameras": [{"number": 5, "imu_T_cam":
    [[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}]})";
  for (const int second : {1, 2}) {
    RunState& state = run.run.states.emplace_back();
    state.time = std::chrono::seconds(second);
    state.world_T_imu.p.x() = second;
    state.health = "ok";
  }
  const PosedUndistorted found = posed_undistorted(run, RunPath::kStates, recording, "out");
  ASSERT_EQ(found.posed.images.size(), 1) << "the camera has one image";
  EXPECT_EQ(found.posed.images[0].file, "out/images/2000000000.png");
  EXPECT_EQ(found.posed.images[0].world_T_cam.p.x(), 2.5);
  EXPECT_NEAR(found.posed.camera.fx, focal_lengths_at_axis(recording.cameras[1]).x(), 1e-12);
  run.summary = R"({"cameras": [{"number": 3}]})";
  EXPECT_THROW(posed_undistorted(run, RunPath::kStates, recording, "out"), InputError);
}

}  // namespace
}  // namespace chasles
