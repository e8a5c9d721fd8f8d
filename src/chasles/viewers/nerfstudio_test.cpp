#include <cmath>
#include <cstring>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/report/testing.hpp>
#include <chasles/viewers/nerfstudio.hpp>

namespace chasles {
namespace {

// One image of a camera at (1, 2, 3) that looks along the world's x axis, with the sky up.
PosedImages one_image(Distortion distortion, const LensCoefficients& coefficients) {
  PosedImages posed;
  posed.camera = {.width = 640,
                  .height = 480,
                  .fx = 500,
                  .fy = 510,
                  .cx = 319.5,
                  .cy = 239.5,
                  .distortion = distortion,
                  .coefficients = coefficients,
                  .cam_T_imu = {}};
  SE3 world_T_cam{{}, {1, 2, 3}};
  world_T_cam.R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  posed.images = {{.file = "data/walk/cam0/7.png", .world_T_cam = world_T_cam}};
  return posed;
}

nlohmann::json transforms_of(const PosedImages& posed) {
  return nlohmann::json::parse(run_nerfstudio({}, posed, "data/out").transforms);
}

TEST(Nerfstudio, ACameraLooksAlongMinusZWithItsYUp) {
  const auto json = transforms_of(one_image(Distortion::kNone, {}));
  ASSERT_EQ(json.at("frames").size(), 1);
  const auto& frame = json["frames"][0];
  EXPECT_EQ(frame.at("file_path"), "../walk/cam0/7.png");
  const auto axis = [&](int column) {
    Eigen::Vector3d a;
    for (int i = 0; i < 3; ++i) a(i) = frame.at("transform_matrix").at(i).at(column).get<double>();
    return a;
  };
  EXPECT_EQ(axis(0), -Eigen::Vector3d::UnitY()) << "right";
  EXPECT_EQ(axis(1), Eigen::Vector3d::UnitZ()) << "up";
  EXPECT_EQ(axis(2), -Eigen::Vector3d::UnitX()) << "backward";
  EXPECT_EQ(axis(3), Eigen::Vector3d(1, 2, 3)) << "camera to world";
  EXPECT_EQ(frame["transform_matrix"][3], nlohmann::json({0.0, 0.0, 0.0, 1.0}));
  EXPECT_EQ(json.at("applied_transform").at(0), nlohmann::json({1.0, 0.0, 0.0, 0.0}));
}

TEST(Nerfstudio, TheImagesCornerIsTheOriginOfItsPixels) {
  const auto json = transforms_of(one_image(Distortion::kNone, {}));
  // The middle of 640 x 480 pixels.
  EXPECT_EQ(json.at("cx"), 320);
  EXPECT_EQ(json.at("cy"), 240);
  EXPECT_EQ(json.at("fl_x"), 500);
  EXPECT_EQ(json.at("fl_y"), 510);
  EXPECT_EQ(json.at("w"), 640);
  EXPECT_EQ(json.at("h"), 480);
}

TEST(Nerfstudio, LensesByTheirModel) {
  auto json = transforms_of(one_image(Distortion::kRadtan, {0.1, 0.2, 0.3, 0.4, 0.5}));
  EXPECT_EQ(json.at("camera_model"), "OPENCV");
  EXPECT_EQ(json.at("k1"), 0.1);
  EXPECT_EQ(json.at("k2"), 0.2);
  EXPECT_EQ(json.at("p1"), 0.3);
  EXPECT_EQ(json.at("p2"), 0.4);
  EXPECT_EQ(json.at("k3"), 0.5);
  json = transforms_of(one_image(Distortion::kRadtan, {0.1, 0.2, 0.3, 0.4}));
  EXPECT_EQ(json.at("k3"), 0);
  json = transforms_of(one_image(Distortion::kEquidistant, {0.1, 0.2, 0.3, 0.4}));
  EXPECT_EQ(json.at("camera_model"), "OPENCV_FISHEYE");
  EXPECT_EQ(json.at("k4"), 0.4);
  EXPECT_THROW(transforms_of(one_image(Distortion::kRadtan, {1, 2, 3, 4, 5, 6, 7, 8})), InputError);
  EXPECT_THROW(transforms_of(one_image(Distortion::kDoubleSphere, {0.1, 0.5})), InputError);
}

TEST(Nerfstudio, ThePointsAreTheFiniteLandmarks) {
  auto run = test::synthetic_drive({.states = 20, .landmarks = 4}).run;
  const std::size_t all = run.landmarks.size();
  run.landmarks[1].p_world.z() = std::nan("");
  const std::string ply = run_nerfstudio(run, one_image(Distortion::kNone, {}), "out").points;
  const std::size_t begin = ply.find("end_header\n") + std::strlen("end_header\n");
  EXPECT_NE(ply.find("element vertex " + std::to_string(all - 1) + "\n"), std::string::npos);
  ASSERT_EQ(ply.size(), begin + (all - 1) * (3 * sizeof(float) + 3));
  float x = 0;
  std::memcpy(&x, ply.data() + begin, sizeof x);
  EXPECT_EQ(x, static_cast<float>(run.landmarks[0].p_world.x()));
}

}  // namespace
}  // namespace chasles
