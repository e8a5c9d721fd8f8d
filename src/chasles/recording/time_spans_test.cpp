#include <cmath>

#include <chasles/recording/image_testing.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/time_spans.hpp>

namespace chasles {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::expect_parts;
using test::input_error;

/// Two seconds of an IMU of 200 Hz and tracks of 20 Hz, from `imu` and `frames` on. `unit`: the
/// nanoseconds that a count of the stamps means.
Recording recording(Time imu, Time frames, int imu_unit = 1, int frame_unit = 1) {
  Recording r;
  for (int k = 0; k <= 400; ++k) r.imu.push_back({.time = (imu + k * milliseconds(5)) / imu_unit});
  for (int k = 0; k < 40; ++k) {
    r.frames.push_back({.time = (frames + k * milliseconds(50)) / frame_unit});
  }
  return r;
}

std::string rejection(const Recording& r) {
  return input_error([&] { check_time_spans("walk", r); });
}

constexpr Time kNow = seconds(1'600'000'000);

TEST(TimeSpans, FramesWithinTheSamplesAreRight) {
  check_time_spans("walk", recording(kNow, kNow));
  check_time_spans("walk", recording(Time{}, Time{}));
  check_time_spans("walk", recording(kNow, kNow + milliseconds(1900)));
  Recording imu_alone = recording(kNow, kNow);
  imu_alone.frames.clear();
  check_time_spans("walk", imu_alone);
}

TEST(TimeSpans, ClocksThatDoNotOverlapAreNamedWithBothSpans) {
  expect_parts(rejection(recording(seconds(5), kNow)),
               {"walk: 401 IMU samples from 5.000 s (no date: since boot",
                "1600000000.000 s (2020-09-13 12:26:40 UTC)", "IMU samples counts since boot"});
  expect_parts(rejection(recording(kNow, seconds(5))), {"clock of the frames counts since boot"});
  expect_parts(rejection(recording(kNow, kNow + seconds(7200))), {"2.00 h", "local time"});
  expect_parts(rejection(recording(kNow, kNow + seconds(3000))), {"of the same recording"});
  for (const int shift : {-10, 10}) {  // no time zone is so near
    const std::string near = rejection(recording(kNow, kNow + seconds(shift)));
    expect_parts(near, {"of the same recording"});
    EXPECT_EQ(near.find("0.00 h"), std::string::npos) << near;
  }
  expect_parts(rejection(recording(kNow, kNow - seconds(900))), {"-0.25 h"});
}

TEST(TimeSpans, OtherUnitsAreRecognised) {
  expect_parts(rejection(recording(kNow, kNow, 1000, 1000)),
               {"at 2e+05 Hz", "microseconds (then 200 Hz)? Multiply them by 1000"});
  expect_parts(rejection(recording(kNow, kNow, 1'000'000)),
               {"IMU samples", "milliseconds (then 200 Hz)"});
  expect_parts(rejection(recording(kNow, kNow, 1, 1000)),
               {"40 frames", "at 2e+04 Hz", "microseconds (then 20 Hz)", "401 IMU samples from"});
  // A slow sensor in a wrong unit has a rate that could be.
  Recording slow = recording(kNow, kNow);
  slow.imu.clear();
  for (int k = 0; k < 3; ++k) slow.velocities.push_back({.time = (kNow + k * seconds(1)) / 1000});
  expect_parts(rejection(slow), {"body velocities", "microseconds, not nanoseconds"});
}

TEST(TimeSpans, StampsThatRepeatAreNamed) {
  std::vector<Time> single, whole, unset(10);
  for (int k = 0; k < 400; ++k) {
    const double time = 1.4e9 + 0.005 * k;
    single.push_back(from_seconds(static_cast<double>(static_cast<float>(time + 128 * (k / 200)))));
    whole.push_back(kNow + seconds(k / 200) + milliseconds(1));
  }
  const auto error = [](const std::vector<Time>& times) {
    return input_error([&] { check_distinct("imu.csv", "IMU samples", times); });
  };
  expect_parts(error(single), {"imu.csv: 400 IMU samples have only 2 different times",
                               "32-bit floating-point seconds, whose steps are 128 s"});
  expect_parts(error(std::vector<Time>(single.begin(), single.begin() + 200)),
               {"only 1 different time,", "32-bit"});
  expect_parts(error(whole), {"only 2 different times", "were they rounded?"});
  expect_parts(error(unset), {"the driver did not set the stamps"});
  check_distinct("imu.csv", "IMU samples", {Time{1}, Time{1}, Time{2}, Time{3}, Time{4}});
}

class ReadersOfTimes : public ::testing::Test {
 protected:
  void SetUp() override { test::write_euroc_folder(folder, 1); }
  void write_samples(const std::string& rows) {
    test::spill(folder / "mav0" / "imu0" / "data.csv", test::kEurocImuColumns + rows);
  }
  std::filesystem::path folder = test::scratch();
};

TEST_F(ReadersOfTimes, EveryReaderChecksTheSpans) {
  std::string rows;
  for (int k = 0; k < 5; ++k) {
    rows += fmt::format("16000000000{}5000000,0.1,0.2,{},1,2,9.5\n", k, k);
  }
  write_samples(rows);
  expect_parts(input_error([&] { read_recording(folder); }),
               {folder.string(), "5 IMU samples from", "3 frames from 0.005 s"});
}

TEST_F(ReadersOfTimes, SamplesThatAreNotANumberAreLeftOut) {
  write_samples(test::five_samples() + "25000000,nan,0.2,0.3,1,2,9.5\n30000000,0,0,0,1,inf,9.5\n");
  const Recording r = read_recording(folder);
  EXPECT_EQ(r.imu.size(), 5u);
  EXPECT_NE(std::find(r.remarks.begin(), r.remarks.end(),
                      "2 of 7 IMU samples are not finite numbers: left out"),
            r.remarks.end());
  write_samples("0,nan,0.2,0.3,1,2,9.5\n");
  expect_parts(input_error([&] { read_recording(folder); }), {"none of the 1 IMU samples"});
}

}  // namespace
}  // namespace chasles
