#include <gtest/gtest.h>

#include <chasles/check/camera_clock.hpp>
#include <chasles/check/check_calibration.hpp>
#include <chasles/check/check_testing.hpp>
#include <chasles/check/lens_fit.hpp>

// A lens, a gyroscope and a readout with one error each; the fit names that error and no other.
namespace chasles {
namespace {

using test::finding;
using test::findings;
using test::tracked;

std::optional<LensFit> lens_of(const Recording& r) {
  const auto seen = seen_twice(r.frames, r.cameras, 0);
  const auto rates = gyroscope_rates(r.imu);
  const auto fit = fit_gyroscope(seen, rates);
  return fit ? fit_lens(seen, rates, *fit) : std::nullopt;
}

// As check_recording() reports the first camera.
CheckReport report_of(const Recording& r) {
  CheckReport report;
  const auto fit = fit_camera(r.frames, r.cameras, 0, gyroscope_rates(r.imu));
  if (fit) report_camera_fit(*fit, r.cameras[0], "cam0", report);
  return report;
}

// The recording with the row of each pixel exposed `readout` times its part of the image later.
Recording rolling(double readout) {
  const Recording still = tracked({.pixel_sigma = 0});
  Recording r = tracked();
  test::Random random(5);
  std::vector<Eigen::Vector3d> points;
  for (int j = 0; j < 300; ++j) {
    const Eigen::Vector3d direction =
        Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    points.push_back(direction * random.uniform(2, 6));
  }
  for (std::size_t k = 0; k < r.frames.size(); ++k) {
    FeatureFrame& frame = r.frames[k];
    frame.pixels.clear();
    const double t = to_seconds(frame.time);
    for (std::size_t j = 0; j < points.size(); ++j) {
      double row = 0.5;  // of the height
      std::optional<PixelProjection> seen;
      for (int i = 0; i < 4; ++i) {
        const SE3 world_T_imu = test::swung_pose(t + (row - 0.5) * readout).pose;
        seen = project(r.cameras[0], r.cameras[0].cam_T_imu * (world_T_imu.inverse() * points[j]));
        if (!seen) break;
        row = seen->pixel.y() / r.cameras[0].height;
      }
      if (!seen || !in_image(r.cameras[0], seen->pixel)) continue;
      const Eigen::Vector2d noise = 0.5 * Eigen::Vector2d(random.normal(), random.normal());
      frame.pixels.push_back(
          {.landmark = static_cast<LandmarkId>(j), .camera = 0, .pixel = seen->pixel + noise});
    }
  }
  return r;
}

TEST(LensFit, OfARecordingWithoutFaultIsTheStatedLens) {
  for (const test::TrackedSettings& settings :
       {test::TrackedSettings{}, test::TrackedSettings{.outliers = 0.15},
        test::TrackedSettings{.wall = true}}) {
    const auto lens = lens_of(tracked(settings));
    ASSERT_TRUE(lens);
    EXPECT_NEAR(lens->radial_at_edge().value, 0, 0.01);
    EXPECT_NEAR(lens->focal.value, 0, 0.02);
    EXPECT_NEAR(lens->gain.value, 1, 0.02);
    EXPECT_NEAR(lens->readout.value, 0, 0.002);
    EXPECT_FALSE(lens->has_wrong_distortion());
    EXPECT_FALSE(lens->is_rolling());
  }
}

TEST(LensFit, AMissingDistortionIsMeasured) {
  Recording r = tracked();
  const Camera right = r.cameras[0];
  for (Camera& camera : r.cameras) {
    camera.distortion = Distortion::kNone;
    camera.coefficients = {};
  }
  const auto lens = lens_of(r);
  ASSERT_TRUE(lens);
  EXPECT_TRUE(lens->has_wrong_distortion());
  // At half of the edge's angle and at the edge, against the lens that made the pixels.
  for (const double part : {0.5, 1.0}) {
    const double angle = part * lens->edge;
    const Eigen::Vector2d pixel(right.cx + right.fx * std::tan(angle), right.cy);
    const auto ray = unproject(right, pixel);
    ASSERT_TRUE(ray);
    const double is = std::atan2(ray->ray.head<2>().norm(), ray->ray.z());
    const double fitted = angle * (1 + lens->focal.value + lens->radial.value * angle * angle);
    EXPECT_NEAR(fitted / is, 1, 0.03) << part;
  }
  const CheckReport report = report_of(r);
  const Finding& wrong = finding(report, "cam0", "its lens is not the stated one");
  EXPECT_EQ(wrong.severity, Severity::kError);
  EXPECT_EQ(findings(report).find("times as fast"), std::string::npos)
      << "the gyroscope is not to blame\n"
      << findings(report);
}

TEST(LensFit, AFisheyeThatIsDeclaredRadtanIsNamed) {
  Recording r = tracked();
  for (Camera& camera : r.cameras) {
    camera.distortion = Distortion::kEquidistant;
    camera.coefficients = {-0.28, 0.07, 1e-4, 2e-5};
  }
  finding(report_of(r), "cam0", "its lens is not the stated one");
}

TEST(LensFit, AGyroscopeOfAnotherScaleIsNoLens) {
  Recording r = tracked();
  for (ImuSample& s : r.imu) s.angular_rate_imu *= 1.25;
  const auto lens = lens_of(r);
  ASSERT_TRUE(lens);
  EXPECT_FALSE(lens->has_wrong_distortion());
  EXPECT_NEAR(lens->gain.value, 0.8, 0.03);
  const Finding& gain = finding(report_of(r), "cam0", "times as fast");
  test::expect_parts(gain.advice, {"the gyroscope's unit"});
  EXPECT_EQ(gain.advice.find("focal"), std::string::npos) << gain.advice;
}

TEST(LensFit, ARollingShutterIsNoOffset) {
  for (const double readout : {0.03, -0.02}) {
    const Recording r = rolling(readout);
    const auto lens = lens_of(r);
    ASSERT_TRUE(lens);
    EXPECT_NEAR(lens->readout.value, readout, 0.003);
    EXPECT_NEAR(lens->offset.value, 0, 0.002);
    EXPECT_FALSE(lens->has_wrong_distortion());
    const CheckReport report = report_of(r);
    EXPECT_NEAR(finding(report, "cam0", "rolling shutter").value, 1e3 * std::abs(readout), 3);
    EXPECT_EQ(findings(report).find("is stamped"), std::string::npos) << findings(report);
  }
  EXPECT_FALSE(lens_of(rolling(0))->is_rolling());
}

// A stated readout is right, or the finding has both. The offset is then that of the first line.
TEST(LensFit, AStatedReadoutIsCompared) {
  Recording r = rolling(0.03);
  r.cameras.front().shutter.readout = 0.03;
  EXPECT_EQ(findings(report_of(r)).find("readout"), std::string::npos) << findings(report_of(r));
  EXPECT_NEAR(fit_camera(r.frames, r.cameras, 0, gyroscope_rates(r.imu))->offset().value, -0.015,
              0.002);
  r.cameras.front().shutter.readout = 0.015;
  const Finding& other = finding(report_of(r), "cam0", "its readout_time says 15.0 ms");
  EXPECT_NEAR(other.value, 15, 3);
  test::expect_parts(other.advice, {"readout_time and readout_direction"});
  r.cameras.front().shutter = {.readout = 0.03, .direction = ReadoutDirection::kUp};
  EXPECT_NEAR(finding(report_of(r), "cam0", "says -30.0 ms").value, 60, 4);
}

}  // namespace
}  // namespace chasles
