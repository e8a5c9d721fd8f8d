#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/noise/imu_alone.hpp>
#include <chasles/calibrate/noise/noise_calibration.hpp>
#include <chasles/calibrate/noise/noise_output.hpp>
#include <chasles/calibrate/noise/noise_testing.hpp>
#include <chasles/calibration/kalibr.hpp>

namespace chasles::test {
namespace {

namespace fs = std::filesystem;

std::string message_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

void expect_message(const std::function<void()>& call, const std::string& part) {
  const std::string message = message_of(call);
  EXPECT_NE(message.find(part), std::string::npos) << message;
}

fs::path empty_folder(const std::string& name) {
  const fs::path folder = fs::path(::testing::TempDir()) / "chasles_calibrate_test" / name;
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

void write_table(const Recording& recording, const fs::path& file) {
  std::ofstream table(file);
  table.precision(17);
  table << "time_ns,wx,wy,wz,ax,ay,az\n";
  for (const ImuSample& s : recording.imu) {
    table << s.time.count() << ',' << s.angular_rate_imu.transpose().format({17, 1, ",", ","})
          << ',' << s.specific_force_imu.transpose().format({17, 1, ",", ","}) << '\n';
  }
}

// Ten minutes are enough for the walk.
const Recording& long_standstill() {
  static const Recording recording = standstill_recording(600, 50, kSensorNoise, 1);
  return recording;
}

TEST(NoiseCalibration, ALongStandstillHasTheDensitiesAndTheWalks) {
  const NoiseCalibration c = calibrate_noise(long_standstill());
  ASSERT_TRUE(c.standstill);
  EXPECT_FALSE(c.motion);
  EXPECT_NEAR(c.standstill_seconds(), 600, 1);
  for (std::size_t i = 0; i < kImuSignals; ++i) {
    const StandstillSignal& signal = (*c.standstill)[i];
    const double N =
        i < 3 ? kSensorNoise.accelerometer_noise_density : kSensorNoise.gyroscope_noise_density;
    const double K =
        i < 3 ? kSensorNoise.accelerometer_random_walk : kSensorNoise.gyroscope_random_walk;
    EXPECT_NEAR(std::log(signal.fit.white.value / N), 0, 3.5 * signal.fit.white.relative_sigma);
    ASSERT_TRUE(signal.fit.walk.shown) << i;
    EXPECT_NEAR(std::log(signal.fit.walk.value / K), 0, 3.5 * signal.fit.walk.relative_sigma);
    EXPECT_NEAR(signal.mean, i == 2 ? kStandardGravity : i < 3 ? 0 : 0.01, 0.02) << i;
    EXPECT_LT(signal.resolution, 1e-6);
  }
  EXPECT_NEAR(c.density(0).value, 2e-3, 4e-5);
  EXPECT_NEAR(c.density(3).value, 1.7e-4, 4e-6);
  ASSERT_TRUE(c.walk(3));
  EXPECT_FALSE(c.walk(3)->is_limit);
  EXPECT_NEAR(c.walk(3)->value, 2e-5, 6e-6);
  EXPECT_TRUE(c.remarks.empty());
}

// The intervals of neighbouring tau share most of their data: nearly all or few contain the model.
TEST(NoiseCalibration, AllanDeviationsAgreeWithTheFitWithinTheirIntervals) {
  const NoiseCalibration c = calibrate_noise(long_standstill());
  std::size_t points = 0, inside = 0;
  for (const StandstillSignal& signal : *c.standstill) {
    EXPECT_NEAR(signal.allan.front().seconds, 0.02, 1e-6);
    EXPECT_GT(signal.allan.back().seconds, 200);
    for (const AllanPoint& p : signal.allan) {
      EXPECT_LT(p.lowest, p.deviation);
      EXPECT_GT(p.highest, p.deviation);
      ++points;
      inside += p.lowest < p.of_fit && p.of_fit < p.highest ? 1 : 0;
    }
  }
  EXPECT_GT(static_cast<double>(inside), 0.85 * static_cast<double>(points));
}

TEST(NoiseCalibration, AShortStandstillStatesLimitsOfTheWalks) {
  const NoiseCalibration c = calibrate_noise(standstill_recording(20, 100, kSensorNoise, 2));
  ASSERT_TRUE(c.walk(3));
  EXPECT_TRUE(c.walk(3)->is_limit);
  EXPECT_GT(c.walk(3)->value, kSensorNoise.gyroscope_random_walk);
  EXPECT_NE(noise_yaml(c).find("not shown: the limit"), std::string::npos);
  EXPECT_NE(noise_text(c).find("<= "), std::string::npos);
  EXPECT_TRUE(noise_json(c)["gyroscope"]["axes"][0]["random_walk"]["value"].is_null());
}

TEST(NoiseCalibration, AMotionGivesDensitiesThatAreLimits) {
  Recording recording = standstill_recording(60, 200, kSensorNoise, 3);
  add_motion(recording, 0, 60);
  const NoiseCalibration c = calibrate_noise(recording);
  EXPECT_FALSE(c.standstill);
  ASSERT_TRUE(c.motion);
  EXPECT_TRUE(c.density(3).is_limit);
  EXPECT_NEAR(c.density(3).value, 1.7e-4, 2e-5);
  EXPECT_FALSE(c.walk(3));
  EXPECT_NE(noise_text(c).find("standstill: less than 5 s"), std::string::npos);
  EXPECT_NE(noise_yaml(c).find("# gyroscope_random_walk"), std::string::npos);
  EXPECT_EQ(allan_csv(c), "axis,tau_s,deviation,low,high,fit,dof,differences\n");
  EXPECT_TRUE(noise_json(c)["standstill"].is_null());
}

TEST(NoiseCalibration, StandstillAndMotionOfOneRecordingAreApart) {
  Recording recording = standstill_recording(60, 200, kSensorNoise, 4);
  add_motion(recording, 30, 60);
  const NoiseCalibration c = calibrate_noise(recording);
  ASSERT_TRUE(c.standstill);
  ASSERT_TRUE(c.motion);
  ASSERT_EQ(c.standstills.size(), 1u);
  EXPECT_NEAR(c.standstills[0].begin, 0, 0.1);
  EXPECT_NEAR(c.standstills[0].end, 29.5, 0.6);
  EXPECT_NEAR(c.motion->seconds, 30, 2);
  EXPECT_FALSE(c.density(0).is_limit);
}

TEST(NoiseCalibration, StartAndStopCutTheRecording) {
  Recording recording = standstill_recording(40, 100, kSensorNoise, 5);
  add_motion(recording, 0, 10);
  const NoiseCalibration c = calibrate_noise(recording, {.start = 12, .stop = 22});
  EXPECT_NEAR(c.seconds, 10, 0.02);
  EXPECT_NEAR(c.standstill_seconds(), 10, 0.02);
  expect_message([&] { calibrate_noise(recording, {.start = 50}); }, "--start 50 s");
}

TEST(NoiseCalibration, AStatedStandstillTakesAllOfIt) {
  Recording recording = standstill_recording(30, 100, kSensorNoise, 6);
  add_motion(recording, 0, 30);
  const NoiseCalibration c = calibrate_noise(recording, {.all_standstill = true});
  ASSERT_TRUE(c.standstill);
  EXPECT_NEAR(c.standstill_seconds(), 30, 0.1);
}

TEST(NoiseCalibration, RejectsWhatShowsNoNoise) {
  Recording none;
  none.name = "none";
  expect_message([&] { calibrate_noise(none); }, "none: found no IMU samples");
  expect_message([] { calibrate_noise(standstill_recording(4, 100, kSensorNoise, 1)); },
                 "found 4.0 s of samples, 4.0 s of standstills");
  expect_message([] { calibrate_noise(standstill_recording(20, 5, kSensorNoise, 1)); },
                 "found 5.00 IMU samples a second, expected at least 8");

  Recording moving = standstill_recording(20, 50, kSensorNoise, 1);  // too slow for a motion
  add_motion(moving, 0, 20);
  expect_message([&] { calibrate_noise(moving); }, "the longest is 0.0 s");

  Recording bursts = standstill_recording(20, 100, kSensorNoise, 1);
  for (std::size_t i = 0; i < bursts.imu.size(); ++i) {
    bursts.imu[i].time =
        from_seconds(0.04 * static_cast<double>(i / 4) + 1e-4 * static_cast<double>(i % 4));
  }
  expect_message([&] { calibrate_noise(bursts); }, "stamps are not even");

  Recording dead = standstill_recording(20, 100, kSensorNoise, 1);
  for (ImuSample& sample : dead.imu) sample.angular_rate_imu.y() = 0.25;
  expect_message([&] { calibrate_noise(dead); },
                 "the gyroscope's y axis shows 0.25 rad/s in all samples, expected noise");

  Recording deaf = standstill_recording(20, 100, kSensorNoise, 1);  // it feels motions alone
  for (ImuSample& sample : deaf.imu) sample.angular_rate_imu.y() = 0.125;
  add_motion(deaf, 15, 20);
  expect_message([&] { calibrate_noise(deaf); },
                 "shows 0.125 rad/s in all samples of a standstill");

  Recording saturated = standstill_recording(20, 100, kSensorNoise, 1);
  saturated.imu_range.accelerometer = kStandardGravity;
  expect_message([&] { calibrate_noise(saturated); }, "at the edge of the sensor's range");
}

TEST(NoiseCalibration, CoarseStepsAreNamed) {
  Recording recording = standstill_recording(60, 100, kSensorNoise, 7);
  for (ImuSample& sample : recording.imu) {  // sigma of a sample: 0.0017
    sample.angular_rate_imu.x() = 0.005 * std::round(sample.angular_rate_imu.x() / 0.005);
  }
  const NoiseCalibration c = calibrate_noise(recording);
  EXPECT_NEAR((*c.standstill)[3].resolution, 0.005, 1e-9);
  ASSERT_FALSE(c.remarks.empty());
  EXPECT_NE(c.remarks[0].find("the gyroscope's x axis has steps of 0.005 rad/s"),
            std::string::npos);
}

TEST(NoiseCalibration, KalibrsReaderReadsTheYaml) {
  const NoiseCalibration c = calibrate_noise(long_standstill());
  const fs::path file = empty_folder("yaml") / "imu.yaml";
  std::ofstream(file) << noise_yaml(c);
  const KalibrCalibration read = read_kalibr_imu(file);
  EXPECT_NEAR(read.imu_noise.accelerometer_noise_density, c.density(0).value, 1e-8);
  EXPECT_NEAR(read.imu_noise.gyroscope_random_walk, c.walk(3)->value, 1e-10);
  EXPECT_EQ(read.imu_topic, "/imu0");
}

TEST(NoiseCalibration, TheTableHasAllPoints) {
  const NoiseCalibration c = calibrate_noise(long_standstill());
  const std::string table = allan_csv(c);
  std::size_t points = 1;
  for (const StandstillSignal& signal : *c.standstill) points += signal.allan.size();
  EXPECT_EQ(static_cast<std::size_t>(std::count(table.begin(), table.end(), '\n')), points);
  EXPECT_NE(table.find("\ngyroscope_z,0.02,"), std::string::npos);
}

TEST(NoiseCalibration, ReadsTablesOfAnImuAlone) {
  const fs::path folder = empty_folder("tables");
  const Recording recording = standstill_recording(10, 100, kSensorNoise, 8);
  write_table(recording, folder / "phone.csv");
  for (const fs::path& path : {folder, folder / "phone.csv"}) {
    const Recording read = read_for_imu(path);
    ASSERT_EQ(read.imu.size(), recording.imu.size());
    EXPECT_EQ(read.imu[5].angular_rate_imu, recording.imu[5].angular_rate_imu);
    EXPECT_NE(read.remarks.back().find("only the IMU's samples were read"), std::string::npos);
  }
  std::ofstream(folder / "notes.txt") << "no table\n";
  expect_message([&] { read_for_imu(folder / "notes.txt"); }, "notes.txt");
  expect_message([&] { read_for_imu(folder / "missing.bag"); }, "missing.bag");
}

// A bag without a calibration beside it, made by an independent writer.
TEST(NoiseCalibration, ReadsTheImuOfABagAlone) {
  const fs::path bags = fs::path(CHASLES_SOURCE_DIR) / "src/chasles/bags/testdata";
  const Recording read = read_for_imu(bags / "none.bag");
  EXPECT_GT(read.imu.size(), 1u);
  EXPECT_TRUE(read.cameras.empty());
}

// The published densities of EuRoC's sensor: 1.7e-4 rad/s and 2e-3 m/s^2 per sqrt(Hz).
TEST(NoiseCalibration, EuRoCsSensorHasItsPublishedDensities) {
  const char* given = std::getenv("CHASLES_DATA");
  const fs::path data = given ? fs::path(given) : fs::path(CHASLES_SOURCE_DIR) / "../shared/data";
  if (!fs::exists(data)) GTEST_SKIP() << "no recordings";
  const NoiseCalibration standstill =
      calibrate_noise(read_for_imu(data / "euroc/imu_gt/MH_01_easy_imu.csv.gz"));
  ASSERT_TRUE(standstill.standstill);
  EXPECT_GT(standstill.standstill_seconds(), 10);
  EXPECT_NEAR(standstill.density(0).value / 2e-3, 1.1, 0.3);
  EXPECT_NEAR(standstill.density(3).value / 1.7e-4, 1.2, 0.3);
  const NoiseCalibration motion = calibrate_noise(read_for_imu(data / "euroc/imu_april"));
  EXPECT_FALSE(motion.standstill);
  EXPECT_NEAR(motion.density(0).value / 2e-3, 1, 0.15);
  EXPECT_NEAR(motion.density(3).value / 1.7e-4, 1, 0.15);
}

}  // namespace
}  // namespace chasles::test
