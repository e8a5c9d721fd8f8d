#include <cmath>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <chasles/run_folder/run.hpp>

#include "cli_process.hpp"

// A calibration in the state of an estimator: what `chasles run` reports of it.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

constexpr const char* kRolling =
    "simulate walk --set walk_duration=20 --set readout_time=0.02 --set distortion=radtan --set "
    "distortion_1=-0.2 --set distortion_2=0.04 -o rec --quiet";

void expect_table(const std::string& estimator) {
  const Scratch folder;
  ASSERT_EQ(chasles(folder, kRolling).code, 0);
  const Outcome run =
      chasles(folder,
              "run rec --begin truth --json --quiet -o out --set calibrate_intrinsics=true "
              "--estimator " +
                  estimator + " --set calibrate_readout=considered");
  ASSERT_EQ(run.code, 0) << run.err;
  const Json summary = Json::parse(run.out);
  std::vector<std::string> names;
  for (const Json& parameter : summary.at("calibration").at("parameters")) {
    const std::string name = parameter.at("name");
    names.push_back(name);
    const bool is_considered = name == "cam0_readout_time";
    EXPECT_EQ(parameter.at("use"), is_considered ? "considered" : "estimated");
    const double stated = parameter.at("stated"), estimate = parameter.at("estimate");
    const double stated_sigma = parameter.at("stated_sigma"), sigma = parameter.at("sigma");
    EXPECT_LT(std::abs(estimate - stated), 4 * sigma) << name << ": what is stated is right";
    if (is_considered) {
      EXPECT_EQ(estimate, stated);
      EXPECT_NEAR(sigma, stated_sigma, 1e-9);
      EXPECT_EQ(parameter.at("observed"), false);
    } else {
      EXPECT_LT(sigma, stated_sigma) << name;
    }
  }
  EXPECT_EQ(names,
            (std::vector<std::string>{"cam0_fx", "cam0_fy", "cam0_cx", "cam0_cy", "cam0_k1",
                                      "cam0_k2", "cam0_p1", "cam0_p2", "cam0_readout_time"}));
  const auto written = read_run(folder / "out");
  const std::vector<std::string> columns(written.extra_names.end() - 9, written.extra_names.end());
  EXPECT_EQ(columns, names);
  EXPECT_EQ(written.states.back().extra.back(), 0.02);
}

TEST(RunWithACalibrationInItsState, HasATableOfAllParameters) {
  for (const char* estimator : {"filter", "batch"}) expect_table(estimator);
}

TEST(RunWithACalibrationInItsState, IsAStateOfAWindowToo) {
  const Scratch folder;
  ASSERT_EQ(chasles(folder,
                    "simulate walk --set walk_duration=10 --set readout_time=0.02 -o rec "
                    "--quiet")
                .code,
            0);
  for (const std::string readout : {"true", "considered"}) {
    const Outcome run = chasles(folder,
                                "run rec --json --quiet --estimator window:20 "
                                "--set calibrate_extrinsics=true --set calibrate_readout=" +
                                    readout);
    ASSERT_EQ(run.code, 0) << run.err;
    const Json parameters = Json::parse(run.out).at("calibration").at("parameters");
    EXPECT_EQ(parameters.size(), 7u);
    for (const Json& p : parameters) {
      const double stated = p.at("stated"), estimate = p.at("estimate"), sigma = p.at("sigma");
      const double stated_sigma = p.at("stated_sigma");
      const bool is_considered = p.at("name") == "cam0_readout_time" && readout == "considered";
      EXPECT_EQ(p.at("use"), is_considered ? "considered" : "estimated");
      if (is_considered) {
        EXPECT_EQ(estimate, stated);
        EXPECT_NEAR(sigma, stated_sigma, 1e-9);
      } else {
        EXPECT_LT(std::abs(estimate - stated), 4 * sigma) << p.at("name");
        EXPECT_LT(sigma, stated_sigma) << p.at("name");
      }
    }
  }
}

// The search begins with the filter's last offset, and so do the start and all frames.
TEST(RunWithACalibrationInItsState, ABatchOfAMovedClockHasTheFramesOfTheFilter) {
  const Scratch folder;
  ASSERT_EQ(chasles(folder, "simulate walk --set walk_duration=8 -o rec --quiet").code, 0);
  for (const char* offset : {"0.003", "-0.003"}) {
    std::vector<std::size_t> frames;
    for (const char* estimator : {"filter", "batch"}) {
      const Outcome run =
          chasles(folder, std::string("run rec --quiet -o out --estimator ") + estimator +
                              " --set calibrate_time_offset=true "
                              "--set time_offset=" +
                              offset);
      ASSERT_EQ(run.code, 0) << run.err;
      frames.push_back(read_run(folder / "out").states.size());
    }
    EXPECT_EQ(frames[0], frames[1]) << offset;
  }
}

TEST(RunWithACalibrationInItsState, WhatIsKnownOrConsideredHidesNothing) {
  const Scratch folder;
  ASSERT_EQ(chasles(folder, "simulate walk --set walk_duration=8 -o rec --quiet").code, 0);
  const Outcome considered = chasles(
      folder, "run rec --estimator batch --json --quiet --set calibrate_extrinsics=considered");
  ASSERT_EQ(considered.code, 0) << considered.err;
  EXPECT_EQ(considered.out.find("neither pixels nor IMU determine"), std::string::npos);
  const Outcome known = chasles(folder,
                                "run rec --estimator batch --json --quiet --set "
                                "calibrate_extrinsics=true --set "
                                "initial_extrinsic_translation_sigma=0");
  ASSERT_EQ(known.code, 0) << known.err;
  EXPECT_EQ(known.out.find("inf sigma"), std::string::npos);
}

TEST(RunWithARollingShutter, MayTakeItForAGlobalOne) {
  const Scratch folder;
  ASSERT_EQ(chasles(folder, kRolling).code, 0);
  const auto ate = [&](const std::string& option) {
    const Outcome run = chasles(folder, "run rec --begin truth --json --quiet " + option);
    EXPECT_EQ(run.code, 0) << run.err;
    return Json::parse(run.out).at("ate_posyaw_m").get<double>();
  };
  EXPECT_GT(ate("--set readout_time=0"), 2 * ate(""));
  const Outcome global =
      chasles(folder, "run rec --json --quiet --set readout_time=0 --set calibrate_readout=true");
  EXPECT_NE(global.out.find("calibrate_readout has no effect"), std::string::npos) << global.err;
  const Outcome far = chasles(folder, "run rec --quiet --set readout_time=20");
  EXPECT_EQ(far.code, 1);
  EXPECT_NE(far.err.find("readout_time"), std::string::npos) << far.err;
}

TEST(CalibrateConvert, WritesTheFilesAndSaysWhatIsLeftOut) {
  const Scratch folder;
  spill(folder / "two cameras.yaml",
        "format: chasles-recording-1\nname: one\ncameras:\n  - resolution: [640, 480]\n"
        "    intrinsics: [300, 301, 320, 240]\n    distortion_model: ds\n"
        "    distortion_coeffs: [0.1, 0.5]\n"
        "    cam_T_imu: [[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n"
        "imu_convention: instant\n");
  const Outcome made = chasles(folder, "calibrate convert 'two cameras.yaml' -o new");
  ASSERT_EQ(made.code, 0) << made.err;
  for (const char* part :
       {"new/kalibr/camchain-imucam.yaml\n", "new/basalt/calibration.json\n",
        "- ROS's file is not written: cam0: ROS's CameraInfo has no lens model ds with 2",
        "- Kalibr's imu.yaml is not written"}) {
    expect_part(made.out, part);
  }
  expect_part(slurp(folder / "new/kalibr/camchain-imucam.yaml"),
              "# Made by `chasles calibrate convert` from two cameras.yaml.");
  expect_error(chasles(folder, "calibrate convert 'two cameras.yaml' -o new"), 1,
               "-o new: is there and not empty, expected a new folder");
  expect_error(chasles(folder, "calibrate convert none.yaml -o other"), 2, "none.yaml");
  expect_error(chasles(folder, "calibrate convert 'two cameras.yaml' -o x --imu-rate 0"), 1,
               "--imu-rate");
  const Outcome quiet =
      chasles(folder, "calibrate convert new/kalibr -o other --quiet --imu-rate 200");
  EXPECT_EQ(quiet.code, 2);  // without the noise of the IMU
  EXPECT_FALSE(std::filesystem::exists(folder / "other"));
}

}  // namespace
}  // namespace chasles::test
