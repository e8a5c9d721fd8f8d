#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/initialise/dynamic_system.hpp>
#include <chasles/initialise/initialiser_testing.hpp>

// The parts of the least squares of the dynamic initialisation.

namespace chasles {
namespace {

using namespace test;

std::vector<ImuInterval> some_intervals() {
  Normal normal(4);
  std::vector<ImuInterval> intervals;
  for (int i = 0; i < 40; ++i) {
    intervals.push_back({.tau = 0.005,
                         .specific_force_imu = Eigen::Vector3d(1, 2, 9) + normal.vector(1),
                         .angular_rate_imu = normal.vector(0.7)});
  }
  return intervals;
}

TEST(Preintegration, IsTheStrapdownStepInAnyFrame) {
  const auto intervals = some_intervals();
  Vector6d biases;
  biases << 0.1, -0.2, 0.05, 0.02, 0.03, -0.01;
  const Preintegration p = preintegrate(intervals, biases, kNoise);
  InertialState state;
  state.world_T_imu = se3::exp((Vector6d() << 0.5, -1, 0.7, 3, -2, 1).finished());
  state.v_world = {1, -2, 0.3};
  state.accelerometer_bias = biases.head<3>();
  state.gyroscope_bias = biases.tail<3>();
  const Eigen::Vector3d gravity(0, 0, -9.8);
  InertialState chain = state;
  Matrix15d F = Matrix15d::Identity(), Q = Matrix15d::Zero();
  for (const ImuInterval& interval : intervals) {
    const StrapdownStep step = strapdown(chain, interval, gravity, kNoise);
    F = (step.F * F).eval();
    Q = (step.F * Q * step.F.transpose() + step.Q).eval();
    chain = step.state;
  }
  const InertialState next = moved(state, p, gravity);
  EXPECT_LT((next.world_T_imu.R - chain.world_T_imu.R).norm(), 1e-12);
  EXPECT_LT((next.world_T_imu.p - chain.world_T_imu.p).norm(), 1e-12);
  EXPECT_LT((next.v_world - chain.v_world).norm(), 1e-12);
  EXPECT_LT((d_moved(state, p) - F.topRows<9>()).norm(), 1e-11);
  Matrix9d turned = Matrix9d::Zero();
  for (int i = 0; i < 9; i += 3) turned.block<3, 3>(i, i) = state.world_T_imu.R;
  const Matrix9d difference = turned * p.Q * turned.transpose() - Q.topLeftCorner<9, 9>();
  EXPECT_LT(difference.norm(), 1e-10 * Q.norm());
}

// Three keyframes that observe points, all at consistent values.
struct Example {
  MotionWindow window;
  MotionStep at;
  MotionWeights weights;
};
Example example(const Camera& camera = test_camera()) {
  Example e;
  Normal normal(5);
  e.at.motion.biases << 0.02, 0.01, -0.03, 0.01, 0.02, -0.01;
  e.at.motion.keyframes.resize(1);
  e.at.motion.keyframes[0].world_T_imu.R = so3::exp({0.1, -0.2, 0.05});
  e.at.motion.keyframes[0].v_world = {2, 0.5, -0.3};
  std::vector<FeatureFrame> frames(3);
  for (int k = 0; k < 2; ++k) {
    e.window.intervals.push_back(some_intervals());
    e.at.between.push_back(preintegrate(e.window.intervals.back(), e.at.motion.biases, kNoise));
    e.at.motion.keyframes.push_back(
        moved(e.at.motion.keyframes.back(), e.at.between.back(), {0, 0, -9.8}));
    const Eigen::Matrix<double, 9, 1> off = Eigen::Matrix<double, 9, 1>::Constant(1e-3);
    e.weights.imu.push_back(100 * Matrix9d::Identity() + off * off.transpose());
  }
  for (std::size_t k = 0; k < 3; ++k) {
    frames[k].time = from_seconds(0.2 * static_cast<double>(k));
    for (int id = 0; id < 6; ++id) {
      frames[k].pixels.push_back({.landmark = id,
                                  .camera = 0,
                                  .pixel = {150.0 + 60 * id + 5 * normal(), 240 + 40 * normal()}});
    }
  }
  auto intervals = std::move(e.window.intervals);
  e.window = make_window(frames, {camera}, 1, 60);
  e.window.intervals = std::move(intervals);
  e.weights.bias_sigma.setConstant(0.1);
  e.weights.gravity = 9.8;
  e.weights.huber = 40;  // some of the residuals are beyond the threshold
  for (const PlaneTrack& track : e.window.tracks) {
    e.at.motion.points.emplace_back(track[0].xy.x() + 0.01, track[0].xy.y(), 0.15);
  }
  return e;
}

// The cost after a change of one unknown: keyframes and biases first, then the points.
double cost_at(const Example& e, Eigen::Index unknown, double by) {
  MotionStep at = e.at;
  const Eigen::Index n = 9 * std::ssize(at.motion.keyframes);
  if (unknown < n) {
    InertialState& state = at.motion.keyframes[static_cast<std::size_t>(unknown / 9)];
    const Eigen::Vector3d d = by * Eigen::Vector3d::Unit(unknown % 3);
    if (unknown % 9 < 3) state.world_T_imu.R = so3::exp(d) * state.world_T_imu.R;
    if (unknown % 9 >= 3 && unknown % 9 < 6) state.world_T_imu.p += d;
    if (unknown % 9 >= 6) state.v_world += d;
  } else if (unknown < n + 6) {
    at.motion.biases[unknown - n] += by;
    for (std::size_t k = 0; k < at.between.size(); ++k) {
      set_biases(e.window.intervals[k], at.motion.biases, at.between[k]);
    }
  } else {
    const Eigen::Index i = unknown - n - 6;
    at.motion.points[static_cast<std::size_t>(i / 3)][i % 3] += by;
  }
  return linearise(e.window, at.between, e.weights, at.motion).cost;
}

// A fisheye camera that has most of these pixels beside or behind it.
Camera wide_camera() {
  Camera camera = test_camera();
  camera.distortion = Distortion::kEquidistant;
  camera.coefficients = {0.01, -0.002, 0, 0};
  camera.fx = camera.fy = 130;
  camera.cx = 500;
  return camera;
}

class MotionSystemOf : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Lens, MotionSystemOf, testing::Bool(), [](const auto& info) {
  return std::string(info.param ? "Wide" : "Pinhole");
});

TEST_P(MotionSystemOf, ItsRightSideIsTheNegativeGradientOfTheCost) {
  const Example e = example(GetParam() ? wide_camera() : test_camera());
  const MotionSystem system = linearise(e.window, e.at.between, e.weights, e.at.motion);
  const Eigen::Index n = system.b.size();
  ASSERT_EQ(n, 9 * 3 + 6);
  ASSERT_EQ(system.tracks.size(), 6U);
  Eigen::VectorXd gradient(n + 18), expected(n + 18);
  expected.head(n) = -system.b;
  for (Eigen::Index i = 0; i < 6; ++i) {
    expected.segment<3>(n + 3 * i) = -system.tracks[static_cast<std::size_t>(i)].b_point;
  }
  for (Eigen::Index i = 0; i < n + 18; ++i) {
    gradient[i] = (cost_at(e, i, 1e-6) - cost_at(e, i, -1e-6)) / 2e-6;
  }
  EXPECT_LT((gradient - expected).norm(), 1e-5 * expected.norm());
  for (Eigen::Index i = 0; i < n + 18; ++i) {
    EXPECT_NEAR(gradient[i], expected[i], 1e-4 * std::abs(expected[i]) + 1e-5 * expected.norm())
        << i;
  }
}

TEST(MotionSystem, KeyframeZeroKeepsPositionAndHeading) {
  const Example e = example();
  const MotionSystem system = linearise(e.window, e.at.between, e.weights, e.at.motion);
  for (const Shooting shooting : {Shooting::kSingle, Shooting::kMultiple}) {
    const auto next = take_step(e.window, system, e.at, 9.8, shooting, 1);
    ASSERT_TRUE(next);
    const SE3 moved_by =
        next->motion.keyframes[0].world_T_imu * e.at.motion.keyframes[0].world_T_imu.inverse();
    EXPECT_EQ(next->motion.keyframes[0].world_T_imu.p, e.at.motion.keyframes[0].world_T_imu.p);
    EXPECT_LT(std::abs(so3::log(moved_by.R).z()), 1e-12);
    EXPECT_GT((next->motion.keyframes[0].v_world - e.at.motion.keyframes[0].v_world).norm(), 0);
  }
}

TEST(Keyframes, AreEvenWithTheFirstAndTheLast) {
  EXPECT_EQ(choose_keyframes(5, 12), (std::vector<std::size_t>{0, 1, 2, 3, 4}));
  const auto chosen = choose_keyframes(61, 7);
  EXPECT_EQ(chosen, (std::vector<std::size_t>{0, 10, 20, 30, 40, 50, 60}));
  EXPECT_EQ(choose_keyframes(1, 12), (std::vector<std::size_t>{0}));
}

// Each view has the axes in which its ray is (x, y, 1), and its ray.
TEST(Window, ViewsBesideTheCameraHaveTheAxesOfAnotherFace) {
  const Camera camera = wide_camera();
  std::vector<FeatureFrame> frames(3);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    frames[k].time = from_seconds(0.1 * static_cast<double>(k));
    for (int id = 0; id < 8; ++id) {
      frames[k].pixels.push_back(
          {.landmark = id, .camera = 0, .pixel = {150.0 + 60 * id, 200.0 + 10 * id}});
    }
  }
  const MotionWindow window = make_window(frames, {camera}, 1, 60);
  ASSERT_EQ(window.tracks.size(), 8U);
  int beside = 0;
  for (const PlaneTrack& track : window.tracks) {
    const PlaneView& view = track.front();
    const auto axes = static_cast<std::size_t>(view.axes);
    beside += axes > 0;
    const Eigen::Vector3d ray(view.xy.x(), view.xy.y(), 1);
    const Eigen::Vector3d in_imu = window.imu_T_cam[axes].R * ray.normalized();
    EXPECT_LT((in_imu - view.ray_imu).norm(), 1e-14);
    const auto seen = project(camera, camera.cam_T_imu.R * view.ray_imu);
    ASSERT_TRUE(seen);
    const auto& pixels = frames[0].pixels;
    EXPECT_TRUE(std::ranges::any_of(
        pixels, [&](const PixelObservation& o) { return (o.pixel - seen->pixel).norm() < 1e-9; }));
    EXPECT_LT((window.imu_T_cam[axes].p - camera.cam_T_imu.inverse().p).norm(), 1e-14);
  }
  EXPECT_GE(beside, 3);
}

TEST(Window, WhatCannotBeUsedIsLeftOut) {
  const Camera camera = test_camera();
  std::vector<FeatureFrame> frames(4);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    frames[k].time = from_seconds(0.1 * static_cast<double>(k));
    frames[k].pixels = {{.landmark = 1, .camera = 0, .pixel = {100, 100}},
                        {.landmark = 1, .camera = 0, .pixel = {300, 300}},  // repeated
                        {.landmark = 2, .camera = 3, .pixel = {100, 100}},
                        {.landmark = 3, .camera = -1, .pixel = {100, 100}},
                        {.landmark = 4, .camera = 0, .pixel = {std::nan(""), 100}}};
    if (k < 2) frames[k].pixels.push_back({.landmark = 5, .camera = 0, .pixel = {9, 9}});
  }
  const MotionWindow window = make_window(frames, {camera}, 1, 60);
  ASSERT_EQ(window.tracks.size(), 1U);
  EXPECT_EQ(window.tracks[0].size(), 4U);
  EXPECT_NEAR(window.tracks[0][0].xy.x(), (100.0 - 320) / 400, 1e-12);
  EXPECT_EQ(window.stereo_tracks, 0);
}

}  // namespace
}  // namespace chasles
