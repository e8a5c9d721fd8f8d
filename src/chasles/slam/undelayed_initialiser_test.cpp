#include <chasles/slam/step_testing.hpp>
#include <chasles/slam/undelayed_initialiser.hpp>

namespace chasles {
namespace {

TEST(UndelayedInitialiser, BeginsLandmarksAtTheirDepthWhileThereIsRoom) {
  test::Random random(3);
  SlamContext x = test::some_context(random);
  x.settings.landmarks = LandmarkForm::kCartesian;
  x.settings.max_landmarks = static_cast<int>(x.state().landmarks.size()) + 2;
  const std::vector<PixelObservation> pixels{{.landmark = 1, .camera = 0, .pixel = {300, 200}},
                                             {.landmark = 1, .camera = 1, .pixel = {310, 200}},
                                             {.landmark = 2, .camera = 0, .pixel = {200, 100}},
                                             {.landmark = 3, .camera = 0, .pixel = {100, 100}}};
  EXPECT_EQ(UndelayedInitialiser(DepthRule{}).initialise(x, test::pointers(pixels)), 2);
  const State& now = x.state();
  EXPECT_EQ(now.landmarks.back().id, 2);
  const Eigen::Vector3d p_imu = now.world_T_imu.inverse() * now.landmarks.back().p_world;
  EXPECT_NEAR((x.camera(0).cam_T_imu * p_imu).z(), x.settings.fixed_depth, 1e-9);
  const UndelayedInitialiser waiting([](const FirstObservation&) { return std::nullopt; });
  EXPECT_FALSE(waiting.landmark(x, 9, 0, {300, 200}, false).has_value());
}

}  // namespace
}  // namespace chasles
