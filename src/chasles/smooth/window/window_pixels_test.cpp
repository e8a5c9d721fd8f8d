#include <gtest/gtest.h>

#include <chasles/camera/camera_testing.hpp>
#include <chasles/filter/testing.hpp>
#include <chasles/smooth/window/window_detail.hpp>

// Views by known cameras, against their cost functions, which sum derivatives by poses.
namespace chasles::smooth_detail {
namespace {

using test::Random;

// Six keyframes.
Window window_of(bool anchored, Random& random) {
  Window window{.sizes = {},
                .chart = &error_chart("standard"),
                .loss = std::make_unique<ceres::HuberLoss>(0.5),
                .anchored = anchored,
                .first = 3};
  for (int k = 0; k < 6; ++k) {
    WindowKeyframe keyframe{.additive = Eigen::VectorXd::Zero(6)};
    write_motion({.world_T_imu = {.R = so3::exp(0.1 * random.normal_vector(3)),
                                  .p = Eigen::Vector3d(0.3 * k, 0.1, 20)},
                  .v_world = {1, 0, 0}},
                 keyframe.motion.data());
    window.keyframes.push_back(std::move(keyframe));
  }
  return window;
}

// A landmark that both cameras see from all keyframes, and once beside them.
WindowPoint point_of(const Window& window, const std::vector<Camera>& cameras, Random& random) {
  WindowPoint point{.anchor = 5, .cam_T_imu = cameras[0].cam_T_imu};
  const SE3 world_T_cam = clone_of(window, 5).world_T_imu * point.cam_T_imu.inverse();
  const Eigen::Vector3d in_camera(0.2, -0.3, 4);
  point.parameters = window.anchored
                         ? Eigen::Vector3d(in_camera.x(), in_camera.y(), 1) / in_camera.z()
                         : world_T_cam * in_camera;
  for (int k = window.first; k <= window.last(); ++k) {
    for (int c = 0; c < 2; ++c) {
      const Camera& camera = cameras[static_cast<std::size_t>(c)];
      const SE3 cam_T_world =
          (clone_of(window, k).world_T_imu * camera.cam_T_imu.inverse()).inverse();
      const auto at = project(camera, cam_T_world * (world_T_cam * in_camera));
      EXPECT_TRUE(at.has_value());
      WindowView view{.keyframe = k, .camera = c};
      view.pixel = PixelTerm{.camera = &camera,
                             .cam_T_imu = camera.cam_T_imu,
                             .of_anchor = point.cam_T_imu,
                             .pixel = at->pixel + 2 * random.normal_vector(2),
                             .sigma = 1.5 + c};
      if (k == 7 && c == 1) view.pixel->least_depth = 10;  // it is nearer: not seen
      point.views.push_back(std::move(view));
    }
  }
  return point;
}

// The same by cost functions.
WindowPoint by_costs(const WindowPoint& point, bool anchored) {
  WindowPoint result{
      .anchor = point.anchor, .cam_T_imu = point.cam_T_imu, .parameters = point.parameters};
  for (const WindowView& view : point.views) {
    WindowView& made = result.views.emplace_back();
    made.keyframe = view.keyframe;
    made.camera = view.camera;
    if (anchored) {
      made.cost = std::make_unique<AnchoredCost<PixelTerm>>(*view.pixel);
      made.at_anchor = std::make_unique<AnchorCost<PixelTerm>>(*view.pixel);
    } else {
      made.cost = std::make_unique<PointCost<PixelTerm>>(*view.pixel);
    }
  }
  return result;
}

void expect_same(const PointLinear& linear, const PointLinear& expected) {
  EXPECT_NEAR(linear.cost, expected.cost, 1e-10 * expected.cost);
  EXPECT_TRUE(test::agree(linear.V, expected.V, 1e-10));
  EXPECT_TRUE(test::agree(linear.b, expected.b, 1e-10));
  ASSERT_EQ(linear.pose_blocks.size(), expected.pose_blocks.size());
  for (std::size_t i = 0; i < linear.pose_blocks.size(); ++i) {
    const auto &block = linear.pose_blocks[i], &other = expected.pose_blocks[i];
    EXPECT_EQ(block.keyframe, other.keyframe);
    EXPECT_TRUE(test::agree(block.H, other.H, 1e-10));
    EXPECT_TRUE(test::agree(block.by_anchor, other.by_anchor, 1e-10));
    EXPECT_TRUE(test::agree(block.W, other.W, 1e-10));
    EXPECT_TRUE(test::agree(block.g, other.g, 1e-10));
  }
}

TEST(WindowPixels, AreLinearisedAsTheirCostFunctions) {
  const std::vector<Camera> cameras = {test::euroc_camera(), [] {
                                         Camera camera = test::euroc_camera();
                                         camera.cam_T_imu.p.x() -= 0.1;
                                         return camera;
                                       }()};
  Random random(1);
  for (const bool anchored : {true, false}) {
    const Window window = window_of(anchored, random);
    WindowPoint point = point_of(window, cameras, random);
    WindowPoint expected = by_costs(point, anchored);
    expect_same(linearise(window, point), linearise(window, expected));
    expect_same(linearise(window, point, 4), linearise(window, expected, 4));
    for (std::size_t i = 0; i < point.views.size(); ++i) {
      EXPECT_NEAR(point.views[i].whitened_norm, expected.views[i].whitened_norm, 1e-10);
      EXPECT_TRUE(test::agree(residual(window, point, point.views[i]),
                              residual(window, expected, expected.views[i]), 1e-10));
    }
  }
}

TEST(WindowPixels, AddedLaterAreAddedToTheSum) {
  const std::vector<Camera> cameras(2, test::euroc_camera());
  Random random(2);
  Window window = window_of(true, random);
  WindowPoint point = point_of(window, cameras, random);
  const PointLinear expected = linearise(window, point);
  std::vector<WindowView> later;
  for (int i = 0; i < 3; ++i) {
    later.insert(later.begin(), std::move(point.views.back()));
    point.views.pop_back();
  }
  window.points.emplace(0, std::move(point));
  window.stale = false;
  evaluate(window);
  WindowPoint& kept = window.points.at(0);
  std::ranges::move(later, std::back_inserter(kept.views));
  evaluate(window);
  expect_same(kept.linear, expected);
  EXPECT_TRUE(test::agree(Eigen::Matrix3d(kept.linear.V_inverse * kept.linear.V),
                          Eigen::Matrix3d(Eigen::Matrix3d::Identity()), 1e-6));
}

TEST(ByNumber, IsInOrderAndRemovesMany) {
  ByNumber<int> values;
  for (const int number : {5, 9, 2, 7, 5}) values.emplace(number, 10 * number);
  values.erase(7);
  values.erase(std::vector<int>{1, 5, 8});
  std::vector<std::pair<int, int>> all(values.begin(), values.end());
  EXPECT_EQ(all, (std::vector<std::pair<int, int>>{{2, 20}, {9, 90}}));
  EXPECT_EQ(values.at(9), 90);
  EXPECT_FALSE(values.contains(5));
  EXPECT_THROW(values.at(5), std::out_of_range);
}

}  // namespace
}  // namespace chasles::smooth_detail
