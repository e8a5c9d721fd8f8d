#include <algorithm>
#include <functional>
#include <numbers>

#include <gtest/gtest.h>

#include <chasles/check/camera_clock.hpp>
#include <chasles/check/check.hpp>
#include <chasles/check/check_calibration.hpp>
#include <chasles/check/check_testing.hpp>
#include <chasles/check/other_axes.hpp>
#include <chasles/lie/so3.hpp>

// A lens with a real distortion and one mistake in its calibration: the check names the mistake,
// and nothing that it explains.
namespace chasles {
namespace {

using test::tracked;

// The recording with the calibration of its first camera changed.
CheckReport with_calibration(const std::function<void(Camera&)>& mistake) {
  static const Recording made = tracked({.seconds = 10});
  Recording r = made;
  r.cameras.resize(1);
  mistake(r.cameras[0]);
  CheckReport report;
  const auto fit = fit_camera(r.frames, r.cameras, 0, gyroscope_rates(r.imu));
  EXPECT_TRUE(fit);
  if (fit) report_camera_fit(*fit, r.cameras[0], "cam0", report);
  return report;
}

// The only finding is this one.
void expect_alone(const CheckReport& report, const std::string& what, const std::string& advice) {
  ASSERT_EQ(report.findings.size(), 1u) << what << "\n" << test::findings(report);
  test::expect_parts(report.findings[0].what, {what});
  test::expect_parts(report.findings[0].advice, {advice});
  EXPECT_EQ(report.findings[0].severity, Severity::kError);
  EXPECT_NEAR(test::fact(report, "cam0", "offset to the gyroscope"), 0, 4) << what;
  EXPECT_LT(test::fact(report, "cam0", "rotation off"), 1.5) << what;
}

TEST(CameraFit, ACalibrationWithoutMistakeHasNone) {
  EXPECT_EQ(test::findings(with_calibration([](Camera&) {})), "");
  EXPECT_EQ(test::findings(with_calibration([](Camera& c) { c.fx *= 1.02, c.fy *= 1.02; })), "");
}

TEST(CameraFit, AnotherFocalLengthIsNamed) {
  for (const double scale : {0.5, 1.1, 1.25}) {
    const CheckReport report = with_calibration([&](Camera& c) { c.fx *= scale, c.fy *= scale; });
    const bool whole = scale == 0.5;
    expect_alone(report, "its focal length is not the stated one",
                 whole ? "2 times the size" : "calibrate the camera again");
    if (!report.findings.empty()) {
      EXPECT_NEAR(report.findings[0].value, 100 * std::abs(scale - 1), 2) << scale;
    }
  }
}

TEST(CameraFit, ACalibrationOfOtherImagesIsNamed) {
  for (const double scale : {0.5, 2.0}) {
    const CheckReport report = with_calibration([&](Camera& c) {
      c.fx *= scale, c.fy *= scale;
      c.cx = (c.cx + 0.5) * scale - 0.5, c.cy = (c.cy + 0.5) * scale - 0.5;
    });
    expect_alone(report, "its focal length is not the stated one",
                 scale < 1 ? "2 times the size" : "0.5 times the size");
  }
}

TEST(CameraFit, CoefficientsInAnotherOrderOrOfAnotherSignAreNamed) {
  const auto change = [](const std::function<LensCoefficients(const LensCoefficients&)>& f) {
    return with_calibration([&](Camera& c) { c.coefficients = f(c.coefficients); });
  };
  expect_alone(change([](const LensCoefficients& k) {
                 return LensCoefficients{k[2], k[3], k[0], k[1]};
               }),
               "its lens is not the stated one", "in another order");
  expect_alone(change([](const LensCoefficients& k) {
                 return LensCoefficients{-k[0], k[1], k[2], k[3]};
               }),
               "its lens is not the stated one", "wrong sign");
}

TEST(CameraFit, AnotherModelIsNamed) {
  expect_alone(with_calibration([](Camera& c) { c.distortion = Distortion::kEquidistant; }),
               "its lens is not the stated one", "the other model");
  expect_alone(with_calibration([](Camera& c) {
                 c.coefficients = {0, 0, 0, 0};
               }),
               "its lens is not the stated one", "are they there");
}

TEST(CameraFit, AnotherPrincipalPointIsNamed) {
  expect_alone(with_calibration([](Camera& c) { std::swap(c.cx, c.cy); }),
               "its principal point is not the stated one", "exchanged");
  expect_alone(with_calibration([](Camera& c) { c.cx -= 80; }),
               "its principal point is not the stated one", "check cx and cy");
}

TEST(CameraFit, UnequalFocalLengthsAreNamed) {
  expect_alone(with_calibration([](Camera& c) { c.fx *= 1.3; }),
               "its focal lengths are not the stated ones", "pixels are square");
}

TEST(CameraFit, AMistakeOfTheLensIsNoOffsetForARun) {
  Recording r = tracked({.seconds = 10});
  for (const double late : {0.0, 0.03}) {
    for (FeatureFrame& frame : r.frames) frame.time += from_seconds(late);
    for (Camera& c : r.cameras) c.coefficients = {1e-4, 2e-5, -0.28, 0.07};
    const auto clock = camera_clock(r.frames, r.cameras, r.imu);
    ASSERT_TRUE(clock);
    EXPECT_NEAR(clock->offset, -late, 0.0015);
  }
}

TEST(CameraFit, SignsOfTheGyroscopeAreNamedByAxis) {
  const Recording made = tracked({.seconds = 10});
  struct Case {
    Eigen::Vector3d signs;
    const char* what;
  };
  for (const Case& c : {Case{{-1, -1, -1}, "mirror image: its sign is wrong"},
                        Case{{1, -1, 1}, "the sign of its y axis is wrong"}}) {
    Recording r = made;
    r.cameras.resize(1);
    for (ImuSample& s : r.imu) s.angular_rate_imu = c.signs.cwiseProduct(s.angular_rate_imu);
    CheckReport report;
    const auto fit = fit_camera(r.frames, r.cameras, 0, gyroscope_rates(r.imu));
    ASSERT_TRUE(fit);
    report_camera_fit(*fit, r.cameras[0], "cam0", report);
    expect_alone(report, c.what, "change the sign of the gyroscope");
    ASSERT_TRUE(camera_clock(*fit));
    EXPECT_NEAR(camera_clock(*fit)->offset, 0, 0.0015);
    const auto axes = other_axes(*fit, r.cameras[0]);
    ASSERT_TRUE(axes);
    EXPECT_EQ(axes->signs, c.signs);
    EXPECT_FALSE(axes->has_turn());
    const auto taken = agreeing_with_gravity(*axes, r.imu);
    ASSERT_TRUE(taken);
    take_axes(*taken, r.imu);
    EXPECT_EQ(r.imu.back().angular_rate_imu, made.imu.back().angular_rate_imu);
    EXPECT_EQ(r.imu.back().specific_force_imu, made.imu.back().specific_force_imu);
  }
}

// Samples of both sensors in other axes, or of the gyroscope alone.
TEST(CameraFit, OtherAxesOfTheSamplesAreUndone) {
  const Recording made = tracked({.seconds = 10});
  Eigen::Matrix3d turn;  // x, y, z of the samples are y, z, x of those that are stated
  turn << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  for (const bool of_gyroscope : {false, true}) {
    Recording r = made;
    for (ImuSample& s : r.imu) {
      s.angular_rate_imu = turn * s.angular_rate_imu;
      if (!of_gyroscope) s.specific_force_imu = turn * s.specific_force_imu;
    }
    const auto rates = gyroscope_rates(r.imu);
    const auto axes = other_axes(fit_camera(r.frames, r.cameras, 0, rates).value(), r.cameras[0]);
    ASSERT_TRUE(axes);
    EXPECT_FALSE(axes->has_signs());
    EXPECT_EQ(axes->imu_R_stated, turn);
    EXPECT_EQ(axes->turned(), "z, x, y");
    EXPECT_LT(axes->rest, 0.02);
    const auto taken = agreeing_with_gravity(*axes, r.imu);
    ASSERT_TRUE(taken);
    EXPECT_EQ(taken->of_gyroscope, of_gyroscope);
    take_axes(*taken, r.imu);
    EXPECT_EQ(r.imu[777].angular_rate_imu, made.imu[777].angular_rate_imu);
    EXPECT_EQ(r.imu[777].specific_force_imu, made.imu[777].specific_force_imu);
  }
}

// The gyroscope's samples have the wrong sign, and the accelerometer's have two: no change of the
// gyroscope lets gravity keep its direction.
TEST(CameraFit, AxesWithWhichGravityTurnsAreNotTaken) {
  Recording r = tracked({.seconds = 10});
  for (ImuSample& s : r.imu) {
    s.angular_rate_imu *= -1;
    s.specific_force_imu.tail<2>() *= -1;
  }
  const auto rates = gyroscope_rates(r.imu);
  const auto axes = other_axes(fit_camera(r.frames, r.cameras, 0, rates).value(), r.cameras[0]);
  ASSERT_TRUE(axes);
  EXPECT_FALSE(agreeing_with_gravity(*axes, r.imu));
}

TEST(CameraFit, AxesThatAreFarFromATurnOrUncertainStay) {
  const Recording made = tracked({.seconds = 10});
  Recording r = made;
  r.cameras[0].cam_T_imu.R = so3::exp({0, 0.7, 0}) * r.cameras[0].cam_T_imu.R;
  const auto rates = gyroscope_rates(r.imu);
  EXPECT_FALSE(other_axes(fit_camera(r.frames, r.cameras, 0, rates).value(), r.cameras[0]));
  r.cameras[0].cam_T_imu.R = so3::exp({0, 0, std::numbers::pi / 2}) * made.cameras[0].cam_T_imu.R;
  CameraFit fit = fit_camera(r.frames, r.cameras, 0, rates).value();
  fit.gyroscope->rotation_sigma = 0.05;
  EXPECT_FALSE(other_axes(fit, r.cameras[0]));
}

// The fit of a flight whose video had half of its rotation taken out.
TEST(CameraFit, AStabilisedVideoHasNoReadoutAndNoOffset) {
  CameraFit fit;
  fit.stated = GyroscopeFit{.rotation_sigma = 0.1,
                            .gain = 0.508,
                            .gain_sigma = 0.036,
                            .offset = -0.0625,
                            .offset_sigma = 0.0086,
                            .intervals = 100};
  fit.gyroscope = fit.stated;
  fit.lens = LensFit{.focal = {-0.057, 0.011},
                     .radial = {0.03, 0.01},
                     .readout = {-0.0362, 0.003},
                     .gain = {0.461, 0.017},
                     .offset = {-0.0774, 0.0072},
                     .edge = 0.7,
                     .intervals = 100};
  CheckReport report;
  report_camera_fit(fit, tracked({.seconds = 1}).cameras[0], "cam0", report);
  ASSERT_EQ(report.findings.size(), 1u) << test::findings(report);
  test::expect_parts(report.findings[0].what, {"images rotate 0.508 times"});
  test::expect_parts(report.findings[0].advice, {"stabilised"});
  test::expect_parts(report.not_checked.at(0), {"clock and rotation of cam0"});
  EXPECT_FALSE(camera_clock(fit));
}

}  // namespace
}  // namespace chasles
