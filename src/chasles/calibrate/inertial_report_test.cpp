#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <unistd.h>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/inertial_files.hpp>
#include <chasles/calibrate/inertial_testing.hpp>

namespace chasles::test {
namespace {

namespace fs = std::filesystem;

TEST(InertialReport, SaysHowGoodItIsAndItsFilesHaveAllRemarks) {
  BoardRigScene scene{.cameras = mounted(1), .time_offset = 0.02, .seconds = 8};
  scene.imu.force.diagonal() << 0.004, -0.003, 0.002;
  InertialReport report;
  report.input = inertial_views(scene, 5);
  report.input.cameras.lenses.clear();
  report.input.cameras.cameras[0].cam_T_imu = {};
  report.remarks = {"said before"};
  calibrate_with_report(report, {{{Distortion::kRadtan, 4}, {Distortion::kNone, 0}}}, false);
  ASSERT_TRUE(report.choices[0]);
  EXPECT_EQ(report.choices[0]->lens.distortion, Distortion::kRadtan);
  EXPECT_TRUE(std::isnan(report.rms_before[0])) << "no lens is stated";
  EXPECT_EQ(report.remarks.front(), "said before");

  const CalibrationToWrite stated{
      .name = "rig", .time_offsets = {0.1}, .has_imu = true, .imu_noise = scene.noise};
  const fs::path folder =
      fs::temp_directory_path() / fmt::format("chasles_inertial_{}", ::getpid());
  write_inertial(report, stated, folder);
  std::ifstream file(folder / "imu-cameras.json");
  const nlohmann::json json = nlohmann::json::parse(file);
  EXPECT_EQ(json, nlohmann::json(inertial_json(report)));
  const auto says_rate = [](const std::string& remark) {
    return remark.find("update_rate") != std::string::npos;
  };
  const auto remarks = json.at("remarks").get<std::vector<std::string>>();
  EXPECT_TRUE(std::ranges::any_of(remarks, says_rate)) << "which is not stated";
  EXPECT_EQ(json.at("cameras")[0].at("lenses").size(), 2u);
  EXPECT_TRUE(fs::exists(folder / "run.yaml"));
  fs::remove_all(folder);
}

TEST(InertialReport, NamesALensThatFits) {
  const BoardRigScene scene{.cameras = mounted(1), .seconds = 8, .frame_rate = 10};
  for (const LensForm& lens : {LensForm{Distortion::kRadtan, 4}, LensForm{Distortion::kEucm, 2}}) {
    InertialReport report;
    report.input = inertial_views(scene, 5);
    report.input.cameras.lenses = {lens};
    report.choices.resize(1);
    report.calibration = calibrate_inertial(report.input);
    const std::vector<std::string> found = lens_contradictions(report);
    if (lens.distortion == Distortion::kRadtan) {
      EXPECT_TRUE(found.empty()) << found[0];
      continue;
    }
    ASSERT_EQ(found.size(), 1u);
    EXPECT_NE(found[0].find("by the views alone and"), std::string::npos) << found[0];
    EXPECT_NE(found[0].find("the lens eucm does not fit; the lens radtan"), std::string::npos)
        << found[0];
  }
}

TEST(InertialReport, WhatWasFoundCorrectsWhatIsStated) {
  ImuIntrinsics intrinsics;
  intrinsics.force.diagonal() << 1.01, 0.98, 1;
  intrinsics.rate_of_force(0, 1) = 1e-3;
  intrinsics.force_bias << 0.1, 0.2, -0.1;
  intrinsics.rate_bias << 0.01, 0, 0.02;
  ImuCorrection found;
  found.has_g_sensitivity = false;
  found.force << 0.004, 0, 0, 0.001, -0.002, 0, 0.002, 0, 0.001;
  found.rate << 0.003, 0.001, -0.002, 0.0015, -0.004, 0.001, -0.001, 0.002, 0.002;
  const CalibrationToWrite both =
      with_found({.name = "rig", .time_offsets = {0.1}, .imu_intrinsics = intrinsics}, mounted(2),
                 {0.02, -0.03}, found);
  EXPECT_EQ(both.cameras.size(), 2u);
  EXPECT_NEAR(both.time_offsets[0], 0.12, 1e-15);
  EXPECT_NEAR(both.time_offsets[1], -0.03, 1e-15);
  ImuSample sample;
  sample.specific_force_imu << 1, -9, 3;
  sample.angular_rate_imu << 0.5, 1, -2;
  const ImuSample twice = corrected(found, corrected(intrinsics, {}, sample));
  const ImuSample once = corrected(*both.imu_intrinsics, {}, sample);
  EXPECT_LT((twice.specific_force_imu - once.specific_force_imu).norm(), 1e-12);
  EXPECT_LT((twice.angular_rate_imu - once.angular_rate_imu).norm(), 1e-12);
  EXPECT_FALSE(with_found({.name = "rig"}, mounted(1), {0}, {}).imu_intrinsics);
}

TEST(InertialReport, RecordingsOfOneRigHaveOneCalibration) {
  const CalibrationToWrite first{.name = "a", .time_offsets = {0.1, 0.2}};
  check_same_rig("a", first, "b", first);
  CalibrationToWrite later = first, means = first, scaled = first;
  later.time_offsets[1] = 0.3;
  means.imu_convention = ImuConvention::kIntervalMean;
  scaled.imu_intrinsics.emplace().force(2, 2) = 1.01;
  for (const auto& [other, what] :
       {std::pair(later, "b: its calibration has another time offset than that of a"),
        {means, "another kind of IMU samples"},
        {scaled, "another scale or axis of the IMU"}}) {
    try {
      check_same_rig("a", first, "b", other);
      ADD_FAILURE() << what;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(what), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace chasles::test
