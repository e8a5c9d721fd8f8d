#include <algorithm>

#include <Eigen/Geometry>

#include <chasles/check/check.hpp>
#include <chasles/check/check_calibration.hpp>
#include <chasles/check/check_imu.hpp>
#include <chasles/check/check_testing.hpp>
#include <chasles/check/check_times.hpp>
#include <chasles/check/check_truth.hpp>
#include <chasles/recording/readers.hpp>

// Each test adds one deficiency to a recording without any and expects its finding. Without it
// there must be no finding.
namespace chasles {
namespace {

using test::fact;
using test::finding;
using test::findings;
using test::tracked;

std::vector<Time> stamps(const std::vector<double>& milliseconds) {
  std::vector<Time> times;
  for (const double ms : milliseconds) times.push_back(from_seconds(ms / 1e3));
  return times;
}

TEST(CheckTimes, CountsWhatIsMissingLateAndRepeated) {
  const TimesCheck check = check_times(stamps({0, 10, 20, 30, 60, 50, 70, 70, 80, 90, 100}));
  EXPECT_EQ(check.count, 11u);
  EXPECT_DOUBLE_EQ(check.interval, 0.01);
  EXPECT_DOUBLE_EQ(check.longest, 0.03);
  EXPECT_DOUBLE_EQ(check.longest_after, 0.03);
  EXPECT_EQ(check.gaps, 1u);
  EXPECT_EQ(check.missing, 2u);
  EXPECT_EQ(check.late, 1u);
  EXPECT_EQ(check.repeated, 1u);
}

TEST(CheckTimes, JitterIsWhatNineInTenIntervalsKeepTo) {
  std::vector<double> ms;
  for (int k = 0; k < 101; ++k) ms.push_back(10 * k + (k % 2 == 0 ? 0 : 3));
  const TimesCheck check = check_times(stamps(ms));
  EXPECT_NEAR(check.jitter, 0.006, 1e-9) << "13 and 7 ms alternate";
  CheckReport report;
  report_times(check, {.interval = 0.05}, "imu", report);
  EXPECT_DOUBLE_EQ(finding(report, "imu", "jitter").value, 1e3 * check.jitter);
}

TEST(CheckTimes, FramesThatAreLostAtRandomDoNotJitter) {
  test::Random random(3);
  for (const double lost : {0.3, 0.5, 0.8}) {
    std::vector<double> ms;
    for (int k = 0; k < 400; ++k) {
      const double noise = 0.3 * random.normal();
      if (random.uniform(0, 1) >= lost) ms.push_back(50 * k + noise);
    }
    const TimesCheck check = check_times(stamps(ms));
    EXPECT_NEAR(check.interval, 0.05, 0.001) << lost;
    EXPECT_LT(check.jitter, 0.002);
    CheckReport report;
    report_times(check, {.interval = 5}, "images", report);
    EXPECT_NEAR(finding(report, "images", "seem to be lost").value, 100 * lost, 8);
    EXPECT_EQ(findings(report).find("jitter"), std::string::npos) << findings(report);
  }
}

TEST(CheckTimes, StampsOfArrivalJitterAndAreNotLost) {
  test::Random random(4);
  std::vector<double> ms;
  for (int k = 0; k < 400; ++k) ms.push_back(50 * k + random.uniform(0, 20));
  const TimesCheck check = check_times(stamps(ms));
  EXPECT_FALSE(check.lossy);
  CheckReport report;
  report_times(check, {.interval = 0.5}, "images", report);
  finding(report, "images", "jitter");
}

TEST(CheckTimes, FewerThanTwoStampsHaveNoRate) {
  for (const auto& times : {stamps({}), stamps({5})}) {
    CheckReport report;
    report_times(check_times(times), {.interval = 0.05}, "imu", report);
    EXPECT_EQ(findings(report), "");
    EXPECT_EQ(report.facts.size(), 1u);
  }
}

TEST(Check, ARecordingWithoutFaultGivesNoFinding) {
  const CheckReport report = check_recording(tracked());
  EXPECT_EQ(findings(report), "");
  EXPECT_TRUE(report.not_checked.empty());
  EXPECT_FALSE(has_error(report));
  EXPECT_NEAR(fact(report, "imu", "rate"), 200, 1e-6);
  EXPECT_NEAR(fact(report, "frames", "rate"), 20, 1e-6);
  EXPECT_NEAR(fact(report, "cam1", "baseline"), 0.12, 1e-9);
  EXPECT_NEAR(fact(report, "cam0", "offset to the gyroscope"), 0, 1);
  EXPECT_LT(fact(report, "cam0", "rotation off"), 0.3);
  EXPECT_LT(fact(report, "cam1", "rotation off"), 0.3);
}

TEST(Check, VelocitiesAlongLevelAxesAreNoted) {
  for (const bool level : {true, false}) {
    Recording r = tracked();
    for (int k = 0; k < 200; ++k) {
      const double t = 0.1 * k, slope = 0.04 * std::sin(t), climb = level ? slope : 0;
      r.velocities.push_back({.time = r.imu.front().time + from_seconds(t),
                              .linear_imu = {9 * std::cos(climb), 0, 9 * std::sin(climb)},
                              .angular_imu = {0, -0.04 * std::cos(t), 0}});
    }
    const CheckReport report = check_recording(r);
    EXPECT_EQ(report.findings.size(), level ? 1u : 0u) << findings(report);
    if (!level) continue;
    const Finding note = finding(report, "velocities", "along level axes");
    EXPECT_EQ(note.severity, Severity::kNote);
    EXPECT_NEAR(note.value, 1, 0.02);
  }
}

TEST(Check, ACameraThatIsLateIsNamedWithItsDelay) {
  for (const double delay : {0.030, -0.031, 0.4}) {
    Recording r = tracked();
    for (FeatureFrame& frame : r.frames) frame.time += from_seconds(delay);
    const CheckReport report = check_recording(r);
    const Finding late =
        finding(report, "cam0", delay > 0 ? "is stamped late by" : "is stamped early by");
    EXPECT_NEAR(late.value, 1e3 * std::abs(delay), 1);
    EXPECT_EQ(late.severity, Severity::kError);
    finding(report, "cam1", delay > 0 ? "is stamped late by" : "is stamped early by");
    if (std::abs(delay) > 0.1) continue;  // frames then lie outside the samples as well
    EXPECT_EQ(report.findings.size(), 2u) << findings(report);
  }
}

TEST(Check, InvertedExtrinsicsAreNamed) {
  Recording r = tracked();
  for (Camera& camera : r.cameras) camera.cam_T_imu = camera.cam_T_imu.inverse();
  const CheckReport report = check_recording(r);
  finding(report, "cam0", "seem to be inverted");
  finding(report, "cam1", "seem to be inverted");
}

TEST(Check, ARotationOfFiveDegreesIsMeasured) {
  Recording r = tracked();
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, -1).normalized();
  r.cameras[0].cam_T_imu.R = so3::exp(axis * 5 * M_PI / 180) * r.cameras[0].cam_T_imu.R;
  const CheckReport report = check_recording(r);
  EXPECT_NEAR(finding(report, "cam0", "rotation against the IMU is off").value, 5, 0.3);
  EXPECT_LT(fact(report, "cam1", "rotation off"), 0.3);
}

TEST(Check, OutliersAndAWallDoNotMislead) {
  for (const test::TrackedSettings& settings :
       {test::TrackedSettings{.outliers = 0.2}, test::TrackedSettings{.wall = true}}) {
    Recording r = tracked(settings);
    for (FeatureFrame& frame : r.frames) frame.time += from_seconds(0.02);
    const CheckReport report = check_recording(r);
    EXPECT_NEAR(finding(report, "cam0", "is stamped late by").value, 20, 2.5);
    EXPECT_LT(fact(report, "cam0", "rotation off"), 1.2);
  }
}

TEST(Check, UnitsOfTheImuAreNamed) {
  Recording r = tracked();
  for (ImuSample& s : r.imu) {
    s.angular_rate_imu *= 180 / M_PI;
    s.specific_force_imu /= kStandardGravity;
  }
  const CheckReport report = check_recording(r);
  test::expect_parts(finding(report, "cam0", "times as fast").advice, {"deg/s"});
  test::expect_parts(finding(report, "imu", "accelerometer shows").advice, {"multiply", "9.81"});
  EXPECT_TRUE(has_error(report));
}

TEST(Check, AFlippedAxisIsNamed) {
  Recording r = tracked();
  for (ImuSample& s : r.imu) s.angular_rate_imu.y() *= -1;
  finding(check_recording(r), "cam0", "only as a mirror image: the sign of its y axis is wrong");
}

TEST(Check, OtherAxesOfTheImuAreNamed) {
  Recording r = tracked();
  for (ImuSample& s : r.imu) {  // forward, right, down instead of forward, left, up
    s.angular_rate_imu.tail<2>() *= -1;
    s.specific_force_imu.tail<2>() *= -1;
  }
  const Finding& off =
      finding(check_recording(r), "cam0", "its rotation against the IMU is off by");
  test::expect_parts(off.advice, {"its samples have x, -y, -z"});
}

TEST(Check, SwappedImagesAreNamed) {
  Recording r = tracked();
  for (FeatureFrame& frame : r.frames) {
    for (PixelObservation& o : frame.pixels) o.camera = 1 - o.camera;
  }
  finding(check_recording(r), "cam1", "would lie behind the cameras");
}

TEST(Check, ATurnedSecondCameraLeavesTheEpipolarLines) {
  Recording r = tracked();
  r.cameras[1].cam_T_imu.R = so3::exp({0.02, 0, 0}) * r.cameras[1].cam_T_imu.R;
  // 0.02 rad of 458 px are 9 px.
  EXPECT_NEAR(finding(check_recording(r), "cam1", "off the epipolar lines").value, 9, 1.5);
}

TEST(Check, ExchangedCalibrationsOfAPairAreNamed) {
  Recording r = tracked({.seconds = 10});
  // A second camera that looks elsewhere, as most do a little.
  r.cameras[1].cam_T_imu =
      SE3{so3::exp({0.04, 0, 0}), Eigen::Vector3d::Zero()} * r.cameras[1].cam_T_imu;
  for (FeatureFrame& frame : r.frames) {
    for (PixelObservation& o : frame.pixels) {
      if (o.camera != 1) continue;
      const auto ray = unproject(r.cameras[1], o.pixel);
      const auto turned =
          ray ? project(r.cameras[1], so3::exp({0.04, 0, 0}) * ray->ray) : std::nullopt;
      o.pixel = turned ? turned->pixel : Eigen::Vector2d(1, 1);
    }
  }
  EXPECT_EQ(findings(check_recording(r)), "");
  std::swap(r.cameras[0], r.cameras[1]);
  test::expect_parts(finding(check_recording(r), "cam1", "off the epipolar lines").advice,
                     {"cam0 and cam1 are exchanged"});
}

TEST(Check, ABaselineInMillimetresOrOfNothingIsNamed) {
  Recording r = tracked();
  r.cameras[1].cam_T_imu.p *= 1000;
  test::expect_parts(finding(check_recording(r), "cam1", "it is ").advice, {"millimetres"});
  r.cameras[1] = r.cameras[0];
  test::expect_parts(finding(check_recording(r), "cam1", "it is ").advice, {"copied"});
}

TEST(Check, GapsDisorderAndMissingSamplesAreNamed) {
  Recording r = tracked();
  r.imu.erase(r.imu.begin() + 1000, r.imu.begin() + 1040);
  r.frames.erase(r.frames.begin() + 100, r.frames.begin() + 140);
  std::swap(r.imu[2000], r.imu[2001]);
  r.imu[3000].time = r.imu[2999].time;
  const CheckReport report = check_recording(r);
  EXPECT_NEAR(finding(report, "imu", "nothing for").value, 0.205, 1e-9);
  EXPECT_NEAR(finding(report, "frames", "nothing for").value, 2.05, 1e-9);
  finding(report, "frames", "seem to be lost");
  EXPECT_EQ(finding(report, "imu", "lie before an earlier one").value, 1);
  EXPECT_EQ(finding(report, "imu", "repeat the one before").value, 1);
}

TEST(Check, FramesWithoutSamplesAndASlowImuAreNamed) {
  Recording r = tracked();
  std::erase_if(r.imu, [](const ImuSample& s) { return s.time > std::chrono::seconds(8); });
  finding(check_recording(r), "frames", "before the first sample of the IMU or after the last");
  Recording slow = tracked();
  std::size_t k = 0;
  std::erase_if(slow.imu, [&](const ImuSample&) { return k++ % 8 != 0; });
  EXPECT_NEAR(finding(check_recording(slow), "imu", "samples a frame").value, 1.25, 1e-6);
}

TEST(Check, AnImuThatIsTooSlowIsNamedWithTheRateThatIsNeeded) {
  for (const std::size_t step : {10u, 1000u}) {
    Recording slow = tracked();
    std::size_t k = 0;
    std::erase_if(slow.imu, [&](const ImuSample&) { return k++ % step != 0; });
    const CheckReport report = check_recording(slow);
    const Finding& rate = finding(report, "imu", "the IMU is too slow");
    EXPECT_EQ(rate.severity, Severity::kError);
    EXPECT_NEAR(rate.value, 200.0 / static_cast<double>(step), 0.1);
    test::expect_parts(rate.advice, {"100 Hz"});
    EXPECT_EQ(findings(report).find("imu: nothing for"), std::string::npos) << findings(report);
  }
}

TEST(Check, SamplesThatAreNoMeasurementsAreCounted) {
  Recording r = tracked();
  ASSERT_FALSE(check_recording(r).findings.size() > 0);
  r.imu[900].specific_force_imu.setConstant(400);
  r.imu[700].specific_force_imu.setZero();
  r.imu[700].angular_rate_imu.setZero();
  EXPECT_EQ(finding(check_recording(r), "imu",
                    "2 samples are no measurements: 1 of six zeros, 1 "
                    "spikes, 0 of a sensor that repeats")
                .value,
            2);
}

// As in the recordings of KITTI that begin before their IMU did.
TEST(Check, StretchesOfInterpolatedSamplesAreNamed) {
  Recording r = tracked();
  test::Random random(3);
  for (ImuSample& s : r.imu) {
    s.specific_force_imu += 0.02 * random.normal_vector(3);
    s.angular_rate_imu += 0.002 * random.normal_vector(3);
  }
  const auto fill = [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first + 1; k < last; ++k) {
      const double x = to_seconds(r.imu[k].time - r.imu[first].time) /
                       to_seconds(r.imu[last].time - r.imu[first].time);
      ImuSample& s = r.imu[k];
      s.specific_force_imu =
          (1 - x) * r.imu[first].specific_force_imu + x * r.imu[last].specific_force_imu;
      s.angular_rate_imu =
          (1 - x) * r.imu[first].angular_rate_imu + x * r.imu[last].angular_rate_imu;
    }
  };
  fill(0, 100);
  fill(600, 660);
  const Finding found = finding(check_recording(r), "imu", "interpolated");
  EXPECT_EQ(found.value, 96 + 56);  // the first of each line show nothing yet
  test::expect_parts(found.what, {"0.02 to 0.50 s, 3.02 to 3.30 s"});
  test::expect_parts(found.advice, {"filled gaps"});
}

TEST(Check, WhatCannotBeTakenFromTheRecordingIsSaid) {
  Recording still = tracked();
  for (ImuSample& s : still.imu) s.angular_rate_imu.setZero();
  EXPECT_EQ(check_recording(still).not_checked.size(), 2u);
  Recording slow = tracked();
  std::size_t k = 0;
  std::erase_if(slow.imu, [&](const ImuSample&) { return k++ % 20 != 0; });
  test::expect_parts(check_recording(slow).not_checked.at(0), {"come at 10 Hz, and 20 Hz are"});
  Recording images = tracked();
  images.frames.clear();
  test::expect_parts(check_recording(images).not_checked.at(0), {"needs tracks"});
  Recording empty;
  empty.name = "empty";
  EXPECT_EQ(findings(check_recording(empty)), "");
}

// A standstill of three seconds, then rotation and oscillation.
std::vector<ImuSample> standstill_and_swing(double gravity) {
  std::vector<ImuSample> imu;
  for (int k = 0; k < 1200; ++k) {
    const double t = 0.005 * k, s = t < 3 ? 0 : std::sin(9 * t);
    imu.push_back({.time = from_seconds(t),
                   .specific_force_imu = {0.1 * s, 0.01 * (k % 3), gravity + 3 * s},
                   .angular_rate_imu = {0.02 + 0.01 * s, 0.3 * s, 0.01 * s}});
  }
  return imu;
}

TEST(CheckImu, StandstillsAreFoundWithTheirBias) {
  const auto standstills = find_standstills(standstill_and_swing(9.81));
  ASSERT_EQ(standstills.size(), 1u);
  EXPECT_NEAR(to_seconds(standstills[0].end), 3, 0.51);
  EXPECT_NEAR(standstills[0].angular_rate_imu.x(), 0.02, 1e-12);
  EXPECT_NEAR(standstills[0].specific_force_imu.z(), 9.81, 1e-9);
}

TEST(CheckImu, GravityAtStandstillMustBeThatOfTheEarth) {
  CheckReport good, weak, none;
  report_imu(standstill_and_swing(9.81), {}, good);
  EXPECT_EQ(findings(good), "");
  report_imu(standstill_and_swing(9.4), {}, weak);
  EXPECT_EQ(finding(weak, "imu", "9.40 m/s^2 at a standstill").severity, Severity::kWarning);
  report_imu(standstill_and_swing(0), {}, none);
  EXPECT_EQ(finding(none, "imu", "0.01 m/s^2 at a standstill").severity, Severity::kError);
}

TEST(CheckImu, AnAttitudeAloneIsNoImu) {
  Recording r = tracked();
  for (ImuSample& s : r.imu) {
    s.specific_force_imu.setZero();
    s.angular_rate_imu.setZero();
  }
  const CheckReport report = check_recording(r);
  EXPECT_EQ(finding(report, "imu", "attitude alone").severity, Severity::kError);
  EXPECT_EQ(report.findings.size(), 1u) << "one cause, one finding:\n" << findings(report);
}

TEST(CheckImu, GravityThatIsRemovedInPartIsSaid) {
  auto imu = standstill_and_swing(9.81);
  for (ImuSample& s : imu) s.specific_force_imu.z() -= 7;
  CheckReport report;
  report_imu(imu, {}, report);
  test::expect_parts(finding(report, "imu", "accelerometer shows").advice, {"gravity", "removed"});
}

TEST(CheckImu, SamplesAtTheEdgeOfTheRangeAreCounted) {
  auto imu = standstill_and_swing(9.81);
  for (int k = 700; k < 707; ++k) imu[static_cast<std::size_t>(k)].specific_force_imu.x() = -39.2;
  CheckReport report;
  report_imu(imu, {.accelerometer = 39}, report);
  EXPECT_EQ(finding(report, "imu", "7 samples are at the edge").value, 7);
}

TEST(CheckImu, ASensorThatIsReadTooFastIsNamed) {
  auto imu = standstill_and_swing(9.81);
  for (std::size_t k = 601; k < imu.size(); k += 2) {
    imu[k].specific_force_imu = imu[k - 1].specific_force_imu;
    imu[k].angular_rate_imu = imu[k - 1].angular_rate_imu;
  }
  CheckReport report;
  report_imu(imu, {}, report);
  EXPECT_NEAR(finding(report, "imu", "same as the one before").value, 25, 1);
}

TEST(CheckImu, AnAxisThatShowsOneNumberIsNamed) {
  std::vector<ImuSample> imu = test::swung({0, 0, -kStandardGravity}, 5).imu;
  CheckReport good, dead;
  report_imu(imu, {}, good);
  EXPECT_EQ(findings(good), "");
  for (ImuSample& sample : imu) sample.angular_rate_imu.y() = 0;
  report_imu(imu, {}, dead);
  finding(dead, "imu", "the gyroscope's y axis shows 0 rad/s in all samples");
}

TEST(CheckCalibration, AnotherSizeOfTheImagesIsNamed) {
  Recording r = tracked();
  for (Camera& camera : r.cameras) {
    camera.width /= 2;
    camera.height /= 2;
  }
  CheckReport report;
  report_lenses(r.cameras, report);
  const Finding& off =
      finding(report, "cam0", "principal point (370.0, 245.0) is far from the middle");
  test::expect_parts(off.advice, {"2 times as large"});
}

TEST(CheckCalibration, AnExchangedPrincipalPointIsNoOtherSize) {
  Recording r = tracked();
  for (Camera& camera : r.cameras) std::swap(camera.cx, camera.cy);
  CheckReport report;
  report_lenses(r.cameras, report);
  test::expect_parts(finding(report, "cam0", "principal point (245.0, 370.0) is far").advice,
                     {"check cx and cy", "order"});
}

TEST(CheckCalibration, AFisheyeWithoutCoefficientsIsNamed) {
  CheckReport report;
  std::vector<Camera> cameras(2);
  cameras[1].distortion = Distortion::kEquidistant;
  report_lenses(cameras, report);
  ASSERT_EQ(report.findings.size(), 1u);
  finding(report, "cam1", "fisheye lens (equidistant)");
}

TEST(CheckImu, ATruthThatLeansIsNamed) {
  Recording r = test::swung({0, 0, -kStandardGravity}, 12);
  CheckReport level, leaning;
  report_truth(r, level);
  EXPECT_EQ(findings(level), "");
  const SE3 lean{so3::exp({0.1, 0, 0}), Eigen::Vector3d::Zero()};
  for (StampedPose& row : r.truth) row.pose = lean * row.pose;
  report_truth(r, leaning);
  EXPECT_NEAR(finding(leaning, "truth", "leans").value, 0.1 * 180 / M_PI, 0.1);
}

TEST(CheckTruth, TurnsAgainstTheGyroscopesAreAFact) {
  Recording r = test::swung({0, 0, -kStandardGravity}, 12);
  const auto apart = [&] {
    CheckReport report;
    report_truth(r, report);
    const auto fact =
        std::ranges::find(report.facts, "turns in 1 s against the gyroscope's", &Fact::name);
    return fact == report.facts.end() ? -1 : fact->value;
  };
  EXPECT_LT(std::abs(apart()), 1);
  for (StampedPose& row : r.truth) row.pose.R *= so3::exp({0, M_PI / 2, 0});
  EXPECT_GT(apart(), 3);
  for (StampedPose& row : r.truth) row.pose.R.setIdentity();
  EXPECT_EQ(apart(), -1) << "positions alone have no turns";
}

// EuRoC's own calibration is accurate to a fraction of a degree and its clocks to a fraction of a
// millisecond. Its tracks have 12 % gross outliers, and the board is a plane.
TEST(CheckReal, EurocAgreesWithItsCalibration) {
  const auto kitti = test::recordings();
  if (!kitti) GTEST_SKIP() << "skipped: no recordings";
  const auto euroc = kitti->parent_path() / "euroc";
  const CheckReport tracks =
      check_recording(read_recording(euroc / "imu_gt/MH_01_easy_klt_tracks_cam0.csv.gz"));
  EXPECT_EQ(findings(tracks), "");
  EXPECT_LT(fact(tracks, "cam0", "rotation off"), 0.5);
  EXPECT_NEAR(fact(tracks, "cam0", "offset to the gyroscope"), 0, 1);
  EXPECT_NEAR(fact(tracks, "cam0", "turns over the gyroscope's"), 1, 0.01);
  const CheckReport board = check_recording(read_recording(euroc / "imu_april"));
  for (const char* camera : {"cam0", "cam1"}) {
    EXPECT_LT(fact(board, camera, "rotation off"), 1.2);
    EXPECT_NEAR(fact(board, camera, "offset to the gyroscope"), 0, 1);
  }
  finding(board, "frames", "nothing for 1.150 s");
}

}  // namespace
}  // namespace chasles
