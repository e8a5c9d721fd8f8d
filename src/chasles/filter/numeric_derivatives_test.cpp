#include <chasles/camera/stereo.hpp>
#include <chasles/filter/numeric_derivatives.hpp>
#include <chasles/filter/pixel_testing.hpp>

namespace chasles {
namespace {

using NumericDerivatives = test::OverCharts;
INSTANTIATE_TEST_SUITE_P(Charts, NumericDerivatives, ::testing::ValuesIn(test::all_charts()),
                         test::chart_test_name);

TEST_P(NumericDerivatives, AreTheAnalyticOnes) {
  test::Random random(3);
  int compared = 0;
  for (const Camera& camera : test::kCameras) {
    for (int i = 0; i < 20; ++i) {
      State x;
      x.world_T_imu = test::random_pose(random, 20);
      x.landmarks = {{.id = 1,
                      .p_world = x.world_T_imu * test::point_ahead(random, random.uniform(2, 20)),
                      .row = 6}};
      auto z = measure_pixel(camera, 1, x, 0, {100, 200});
      if (!z) continue;
      const Measurement analytic = *z;
      differentiate_numerically(chart(), camera, x, *z);
      EXPECT_GT((z->d_core - analytic.d_core).norm(), 0) << "they are not the analytic ones";
      EXPECT_TRUE(test::agree(z->d_core, analytic.d_core, 1e-6));
      EXPECT_TRUE(test::agree(z->d_landmark, analytic.d_landmark, 1e-6));
      EXPECT_EQ(z->residual, analytic.residual);
      ++compared;
    }
  }
  EXPECT_GT(compared, 40);
}

TEST(NumericDerivativesAtTheEdge, WithoutAProjectionTheAnalyticOnesStay) {
  const Camera& camera = test::kCameras.front();
  State x;
  // On the edge of what the camera sees: a perturbed point is behind it.
  const SE3 imu_T_cam = camera.cam_T_imu.inverse();
  x.landmarks = {
      {.id = 1, .p_world = imu_T_cam * Eigen::Vector3d(0, 0, kMinDepth + 1e-6), .row = 6}};
  auto z = measure_pixel(camera, 1, x, 0, {100, 200});
  ASSERT_TRUE(z);
  const Measurement analytic = *z;
  differentiate_numerically(kStandardChart, camera, x, *z);
  EXPECT_EQ(z->d_core, analytic.d_core);
}

}  // namespace
}  // namespace chasles
