#include <gtest/gtest.h>

#include <chasles/base/constants.hpp>
#include <chasles/camera/camera_testing.hpp>
#include <chasles/camera/rig_overlap.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles::test {
namespace {

// A pinhole whose half field of view is 45 degrees to the sides and up.
Camera square_camera(double yaw, double aside = 0) {
  Camera camera{
      .width = 400, .height = 400, .fx = 200, .fy = 200, .cx = 200, .cy = 200, .cam_T_imu = {}};
  camera.cam_T_imu = SE3{so3::exp({0, yaw, 0}), {aside, 0, 0}}.inverse();
  return camera;
}

std::vector<Camera> ring(int cameras) {
  std::vector<Camera> rig;
  for (int i = 0; i < cameras; ++i) rig.push_back(square_camera(2 * M_PI * i / cameras));
  return rig;
}

TEST(RigOverlap, SharedViewIsTheShareOfTheAngles) {
  const Camera ahead = square_camera(0);
  EXPECT_EQ(shared_view(ahead, {ahead}), 1);
  EXPECT_EQ(shared_view(ahead, {}), 0);
  EXPECT_EQ(shared_view(ahead, {square_camera(M_PI)}), 0);
  // Turned by atan(1/2): columns beyond tan(45 - 26.57 degrees) = 1/3 are out of its view on one
  // side, and less of the rows near the other.
  const double turned = shared_view(ahead, {square_camera(std::atan(0.5))});
  EXPECT_LT(turned, 2.0 / 3);
  EXPECT_GT(turned, 0.5);
  // What two neighbours see together is what either sees.
  EXPECT_NEAR(shared_view(ahead, {square_camera(std::atan(0.5)), square_camera(-std::atan(0.5))}),
              0.9, 0.1);
}

TEST(RigOverlap, CountsWhatIsFiveMetresAway) {
  // Beside each other by half the width of the view at the nominal depth, on the axis' plane.
  const double shared = shared_view(square_camera(0), {square_camera(0, 5 / std::sqrt(2.0))});
  EXPECT_GT(shared, 0.4);
  EXPECT_LT(shared, 0.75);
  EXPECT_GT(shared_view(square_camera(0), {square_camera(0, 0.1)}), 0.95);
}

TEST(RigOverlap, PixelsWithoutARayDoNotCount) {
  const Camera fisheye = fisheye_camera();  // its corners have no ray
  EXPECT_EQ(shared_view(fisheye, {fisheye}), 1);
}

TEST(RigOverlap, OfAStereoPairOnlyTheFirstFinds) {
  const std::vector<Finder> finders = finders_of({square_camera(0), square_camera(0, 0.2)});
  ASSERT_EQ(finders.size(), 1u);
  EXPECT_EQ(finders[0].camera, 0u);
  EXPECT_EQ(finders[0].searched, (std::vector<std::size_t>{1}));
}

TEST(RigOverlap, OfARingEachFindsAndSearchesWhereItOverlaps) {
  const std::vector<Finder> apart = finders_of(ring(4));
  ASSERT_EQ(apart.size(), 4u);
  for (const Finder& finder : apart) EXPECT_TRUE(finder.searched.empty());
  const std::vector<Finder> five = finders_of(ring(5));
  ASSERT_EQ(five.size(), 5u);
  EXPECT_EQ(five[0].searched, (std::vector<std::size_t>{1, 4}));
  EXPECT_EQ(five[2].searched, (std::vector<std::size_t>{1, 3}));
  EXPECT_EQ(are_finders(ring(6)), (std::vector<bool>{true, true, true, true, true, false}))
      << "the last one is between two others";
}

TEST(RigOverlap, CamerasThatSeeNothingInCommonDetermineNoDepth) {
  EXPECT_EQ(cameras_in_stereo(ring(1)), 1u);
  EXPECT_EQ(cameras_in_stereo(ring(4)), 1u);
  EXPECT_EQ(cameras_in_stereo(ring(6)), 6u);
  EXPECT_EQ(cameras_in_stereo({square_camera(0), square_camera(0, 0.1)}), 2u);
}

TEST(RigOverlap, TwoStereoPairsHaveTwoFinders) {
  const std::vector<Camera> rig = {square_camera(0), square_camera(M_PI), square_camera(0, 0.1),
                                   square_camera(M_PI, 0.1)};
  const std::vector<Finder> finders = finders_of(rig);
  ASSERT_EQ(finders.size(), 2u);
  EXPECT_EQ(finders[0].searched, (std::vector<std::size_t>{2}));
  EXPECT_EQ(finders[1].camera, 1u);
  EXPECT_EQ(finders[1].searched, (std::vector<std::size_t>{3}));
  EXPECT_EQ(are_finders(rig), (std::vector<bool>{true, true, false, false}));
}

TEST(RigOverlap, AWideCameraAfterANarrowOneFindsToo) {
  Camera narrow = square_camera(0);
  narrow.fx = narrow.fy = 1000;
  EXPECT_EQ(are_finders({narrow, square_camera(0)}), (std::vector<bool>{true, true}));
  EXPECT_EQ(are_finders({square_camera(0), narrow}), (std::vector<bool>{true, false}));
  narrow.fx = narrow.fy = 2000;  // a hundredth of the wide one
  EXPECT_EQ(finders_of({square_camera(0), narrow}).front().searched, std::vector<std::size_t>{1});
}

TEST(RigOverlap, TracksAreSharedAndEachFinderHasEnough) {
  EXPECT_EQ(tracks_per_finder(150, 1), 150);
  EXPECT_EQ(tracks_per_finder(150, 2), 75);
  EXPECT_EQ(tracks_per_finder(150, 8), 40);
  EXPECT_EQ(tracks_per_finder(30, 4), 30);
}

}  // namespace
}  // namespace chasles::test
