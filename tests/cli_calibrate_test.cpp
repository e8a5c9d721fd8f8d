#include <nlohmann/json.hpp>

#include "cli_test.hpp"

// `chasles calibrate` end to end. What it measures is tested in src/chasles/calibrate.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

void simulate_standstill(const Scratch& folder) {
  const Outcome made = chasles(folder,
                               "simulate walk -o rec --quiet --set rest_duration=40 "
                               "--set walk_duration=60 --set frame_rate=1 --set imu_rate=100");
  ASSERT_EQ(made.code, 0) << made.err;
}

TEST(CalibrateNoise, WritesAndPrintsWhatItMeasures) {
  const Scratch folder;
  simulate_standstill(folder);
  const Outcome table = chasles(folder, "calibrate noise rec -o noise");
  ASSERT_EQ(table.code, 0) << table.err;
  for (const char* part :
       {"standstill: 40.0 s in 1 part", "gyroscope", "noise density [rad/s/sqrt(Hz)]",
        "a filter takes", "The recording states 0.00"}) {
    expect_part(table.out, part);
  }
  expect_part(slurp(folder / "noise/imu.yaml"), "\ngyroscope_noise_density: 0.0001");
  expect_part(slurp(folder / "noise/allan.csv"), "axis,tau_s,deviation,low,high,fit");
  const Outcome printed = chasles(folder, "calibrate noise rec --json");
  ASSERT_EQ(printed.code, 0) << printed.err;
  EXPECT_EQ(printed.out, slurp(folder / "noise/noise.json"));
  const Json json = Json::parse(printed.out);
  for (const std::string sensor : {"accelerometer", "gyroscope"}) {
    const double stated = json["stated"][sensor + "_noise_density"];
    EXPECT_NEAR(json[sensor]["noise_density"]["value"].get<double>() / stated, 1, 0.06) << sensor;
  }
  EXPECT_TRUE(json["gyroscope"]["random_walk"]["is_limit"].get<bool>());
  EXPECT_NEAR(json["motion"]["seconds"].get<double>(), 20, 2);
}

TEST(CalibrateNoise, ErrorsNameTheRecording) {
  const Scratch folder;
  simulate_standstill(folder);
  expect_error(chasles(folder, "calibrate noise rec --stop 4"), 2,
               "walk: found 4.0 s of samples, 4.0 s of standstills");
  expect_error(chasles(folder, "calibrate noise rec --start 90"), 1, "--start 90 s");
  expect_error(chasles(folder, "calibrate noise rec -o ''"), 1, "expected a path");
  expect_error(chasles(folder, "calibrate noise missing"), 2, "missing: no such file");
  spill(folder / "file", "");
  expect_error(chasles(folder, "calibrate noise rec -o file"), 1, "the folder cannot be made");
  ASSERT_EQ(chasles(folder, "simulate street -o drive --quiet --set route=R").code, 0);
  expect_error(chasles(folder, "calibrate noise drive"), 2, "found no IMU samples");
}

}  // namespace
}  // namespace chasles::test
