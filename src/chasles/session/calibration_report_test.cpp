#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chasles/camera/camera_testing.hpp>
#include <chasles/session/calibration_report.hpp>
#include <chasles/slam/inertial_calibration.hpp>

namespace chasles {
namespace {

InertialSlamSettings everything(Calibrate use) {
  InertialSlamSettings settings;
  settings.calibrate_extrinsics = settings.calibrate_intrinsics = use;
  settings.calibrate_time_offset = settings.calibrate_imu = use;
  return settings;
}

const std::vector<Camera> kReported{test::euroc_camera(), test::fisheye_camera()};

nlohmann::ordered_json parameter(const nlohmann::ordered_json& calibration,
                                 const std::string& name) {
  for (const auto& one : calibration["parameters"]) {
    if (one["name"] == name) return one;
  }
  ADD_FAILURE() << name;
  return {};
}

TEST(CalibrationReport, HasAColumnForEachParameter) {
  const InertialSlamSettings settings = everything(Calibrate::kTrue);
  const auto names = calibration_columns(settings, kReported);
  EXPECT_EQ(std::set(names.begin(), names.end()).size(), names.size());
  // Extrinsics, offset, four and the lens of each camera, IMU.
  EXPECT_EQ(names.size(), 12u + 1 + 8 + 4 + 4 + 24);
  RunState state;
  append_calibration(*stated_calibration(settings, kReported), kReported, state);
  EXPECT_EQ(state.extra.size(), names.size());
  EXPECT_EQ(state.extra_sigma.size(), names.size());
  EXPECT_EQ(names.back(), "g_sensitivity_z_z");
  EXPECT_EQ(state.extra_sigma.back(), settings.initial_g_sensitivity_sigma);
}

TEST(CalibrationReport, OfTheImuSaysWhatWasObservedAndWhatIsFar) {
  const InertialSlamSettings settings = everything(Calibrate::kTrue);
  Calibration calibration = *stated_calibration(settings, kReported);
  Eigen::VectorXd errors = Eigen::VectorXd::Zero(24);
  errors[1] = 0.02;  // accelerometer's scale of y, four sigmas
  calibration.imu->add(errors);
  const int row = calibration.imu_row() + 1;
  calibration.covariance(row, row) = 1e-6;
  const auto report = calibration_json(calibration, kReported, settings);
  const auto found = parameter(report, "accelerometer_scale_y");
  EXPECT_EQ(found["estimate"], 0.02);
  EXPECT_EQ(found["stated"], 0);
  EXPECT_EQ(found["stated_sigma"], 0.005);
  EXPECT_EQ(found["sigma"], 1e-3);
  EXPECT_EQ(found["use"], "estimated");
  EXPECT_EQ(found["observed"], true);
  EXPECT_EQ(parameter(report, "gyroscope_misalignment_x_z")["unit"], "rad");
  EXPECT_EQ(parameter(report, "gyroscope_misalignment_x_z")["observed"], false);
  EXPECT_EQ(parameter(report, "g_sensitivity_x_z")["unit"], "rad/s/(m/s^2)");
  const auto remarks = calibration_remarks(calibration, kReported, settings);
  ASSERT_EQ(remarks.size(), 2u);
  EXPECT_NE(remarks[0].find("did not observe"), std::string::npos);
  EXPECT_EQ(remarks[0].find("accelerometer_scale_y"), std::string::npos);
  EXPECT_NE(remarks[0].find("gyroscope_scale_x"), std::string::npos);
  EXPECT_NE(remarks[1].find("accelerometer_scale_y (4.0 sigma)"), std::string::npos);
}

TEST(CalibrationReport, OfWhatIsConsideredHasNoRemark) {
  const InertialSlamSettings settings = everything(Calibrate::kConsidered);
  const Calibration calibration = *stated_calibration(settings, kReported);
  const auto report = calibration_json(calibration, kReported, settings);
  for (const auto& one : report["parameters"]) {
    EXPECT_EQ(one["use"], "considered") << one["name"];
    EXPECT_EQ(one["observed"], false) << one["name"];
  }
  EXPECT_TRUE(calibration_remarks(calibration, kReported, settings).empty());
}

}  // namespace
}  // namespace chasles
