#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/calibrate_testing.hpp>
#include <chasles/calibrate/cameras_report.hpp>
#include <chasles/calibrate/capture_guide.hpp>
#include <chasles/camera/camera_testing.hpp>

namespace chasles::test {
namespace {

std::vector<Camera> guided_rig(int cameras) {
  std::vector<Camera> rig(static_cast<std::size_t>(cameras), euroc_camera());
  for (std::size_t c = 0; c < rig.size(); ++c) {
    rig[c].cam_T_imu = {};
    rig[c].cam_T_imu.p.x() = -0.1 * static_cast<double>(c);
  }
  return rig;
}

CaptureGuide guide_of(CamerasInput input) {
  input.views.clear();
  return CaptureGuide(std::move(input));
}

void add_all(const std::vector<TargetView>& views, CaptureGuide& guide) {
  for (const TargetView& view : views) guide.add(view);
}

std::size_t count_part(const std::vector<std::string>& sentences, const std::string& part) {
  std::size_t count = 0;
  for (const std::string& one : sentences) count += one.find(part) != std::string::npos ? 1 : 0;
  return count;
}

// What it says at the end is what the calibration says of the same views.
TEST(CaptureGuide, SaysWhatTheCalibrationWouldLack) {
  for (const double tilt : {0.1, 0.9}) {
    const CamerasInput input =
        board_views({.cameras = guided_rig(2), .instants = 60, .most_tilt = tilt}, 4);
    CaptureGuide guide = guide_of(input);
    EXPECT_EQ(count_part(guide.missing(), "has not seen the target"), 2u);
    add_all(input.views, guide);
    const CamerasCalibration found = calibrate_cameras(input);
    std::vector<std::string> missing = missing_views(input, found.views);
    EXPECT_EQ(count_part(missing, "leans by at most"), tilt < 0.3 ? 8u : 0u);
    // The degrees are by other lenses: the sentences are about the same things.
    const std::vector<std::string> guided = guide.missing();
    ASSERT_EQ(guided.size(), missing.size());
    for (std::size_t i = 0; i < missing.size(); ++i) {
      EXPECT_EQ(guided[i].substr(0, 30), missing[i].substr(0, 30));
    }
    EXPECT_EQ(guide.pieces(), found.pieces);
  }
}

TEST(CaptureGuide, EstimatesTheLensFromNothing) {
  const CamerasInput input = board_views({.cameras = guided_rig(1), .instants = 70}, 5);
  CaptureGuide guide = guide_of(input);
  double first = 0;
  for (const TargetView& view : input.views) {
    guide.add(view);
    if (first == 0 && guide.estimate(0)) first = guide.estimate(0)->sigma;
  }
  const auto& estimate = guide.estimate(0);
  ASSERT_TRUE(estimate);
  EXPECT_NEAR(estimate->focal_length, euroc_camera().fx, 4 * estimate->sigma);
  EXPECT_LT(estimate->sigma, 0.5 * first) << "more views";
  EXPECT_NEAR(estimate->rms, 0.2 * std::sqrt(2), 0.03);
}

TEST(CaptureGuide, NamesThePartOfTheImageThatIsOpen) {
  CamerasInput input = board_views({.cameras = guided_rig(1), .instants = 40}, 6);
  CaptureGuide guide = guide_of(input);
  for (TargetView view : input.views) {
    TargetView kept{view.time, view.camera, {}, {}};
    for (std::size_t i = 0; i < view.ids.size(); ++i) {
      if (view.pixels[i].x() < 740 / 1.5 || view.pixels[i].y() > 240) {
        kept.ids.push_back(view.ids[i]);
        kept.pixels.push_back(view.pixels[i]);
      }
    }
    guide.add(kept);
  }
  const std::vector<std::string> missing = guide.missing();
  ASSERT_FALSE(missing.empty());
  EXPECT_NE(missing[0].find("first at the upper right"), std::string::npos) << missing[0];
}

TEST(CaptureGuide, CamerasNeedInstantsInCommon) {
  CamerasInput input = board_views({.cameras = guided_rig(2), .instants = 30}, 2);
  for (TargetView& view : input.views) view.time += std::chrono::nanoseconds(view.camera);
  CaptureGuide guide = guide_of(input);
  add_all(input.views, guide);
  const std::vector<std::string> missing = guide.missing();
  ASSERT_FALSE(missing.empty());
  EXPECT_EQ(missing[0].substr(0, 60),
            "cam1: it and cam0 see the target together at 0 instants: sho");
}

TEST(CaptureGuide, ViewsThatAreAlikeOrBlurredAreNotEnough) {
  const CamerasInput input = board_views({.cameras = guided_rig(1), .instants = 1}, 3);
  CaptureGuide guide = guide_of(input);
  for (int i = 0; i < 100; ++i) {
    TargetView view = input.views[0];
    view.time += std::chrono::seconds(i);
    guide.add(view, i < 60 ? 3.0 : 0.5);
  }
  EXPECT_EQ(guide.views(0), 100u);
  EXPECT_EQ(guide.pieces(), 1);
  EXPECT_EQ(count_part(guide.missing(), "60 of 100 views are blurred"), 1u);
  EXPECT_EQ(count_part(guide.missing(), "the views are 1 independent ones"), 1u);
}

TEST(CaptureGuide, SaysThatNoLensHasTheCorners) {
  CamerasInput input = board_views({.cameras = guided_rig(1), .instants = 30}, 7);
  for (std::size_t i = 0; i < input.corners.size(); i += 3) input.corners[i].x() += 1;
  CaptureGuide guide = guide_of(input);
  add_all(input.views, guide);
  ASSERT_FALSE(guide.missing().empty());
  if (guide.estimate(0)) {
    EXPECT_GT(guide.estimate(0)->rms, 10) << "it is another target";
  } else {
    EXPECT_NE(guide.missing().back().find("has no calibration by these views"), std::string::npos);
  }
}

TEST(CaptureGuide, RejectsWhatIsNoView) {
  const CamerasInput input = board_views({.cameras = guided_rig(1), .instants = 1}, 3);
  CaptureGuide guide = guide_of(input);
  TargetView view = input.views[0];
  view.camera = 1;
  EXPECT_THROW(guide.add(view), UsageError);
  view.camera = 0;
  view.pixels[0] = {-50, 0};
  EXPECT_THROW(guide.add(view), InputError);
  EXPECT_EQ(guide.views(0), 0u);
  EXPECT_THROW(CaptureGuide({}), UsageError);
}

}  // namespace
}  // namespace chasles::test
