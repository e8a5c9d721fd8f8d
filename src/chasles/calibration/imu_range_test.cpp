#include <cmath>

#include <chasles/calibration/imu_range.hpp>
#include <chasles/recording/apply_calibration.hpp>
#include <chasles/recording/inertial_testing.hpp>
#include <chasles/recording/readers.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;

constexpr double kRange = 39.2266;

// Two seconds of motion with noise; the force exceeds `range` and is clipped there.
std::vector<ImuSample> clipped(double range) {
  test::Random random(4);
  std::vector<ImuSample> imu = test::swung({0, 0, -kStandardGravity}, 2).imu;
  for (std::size_t k = 0; k < imu.size(); ++k) {
    Eigen::Vector3d& f = imu[k].specific_force_imu;
    f.x() += 60 * std::sin(0.05 * static_cast<double>(k)) + 0.02 * random.normal();
    for (double& x : f) x = std::clamp(x, -range, range);
  }
  return imu;
}

TEST(ImuRange, ClippingShowsTheRangeAndWhatIsBeyond) {
  const auto imu = clipped(kRange);
  const ImuRange range = shown_range(imu);
  EXPECT_NEAR(range.accelerometer, kRange, 1.001e-3 * kRange);
  EXPECT_LE(range.accelerometer, kRange);
  EXPECT_TRUE(std::isinf(range.gyroscope));
  std::size_t beyond = 0;
  const auto whole = clipped(1e9);
  for (const ImuSample& s : whole) beyond += s.specific_force_imu.cwiseAbs().maxCoeff() >= kRange;
  ASSERT_GT(beyond, 50u);
  EXPECT_NEAR(static_cast<double>(count_saturated(imu, range)), static_cast<double>(beyond), 2);
}

TEST(ImuRange, NothingIsClaimedWithoutClipping) {
  const auto infinite = [](const ImuRange& range) {
    return std::isinf(range.accelerometer) && std::isinf(range.gyroscope);
  };
  EXPECT_TRUE(infinite(shown_range({})));
  EXPECT_TRUE(infinite(shown_range(clipped(1e9)))) << "large, but not clipped";
  EXPECT_TRUE(infinite(shown_range(clipped(15)))) << "no sensor clips there";
  auto peak = clipped(1e9);
  peak[50].specific_force_imu.y() = peak[51].specific_force_imu.y() = 200;
  EXPECT_TRUE(infinite(shown_range(peak))) << "two of a kind";
  auto fast = clipped(1e9);
  for (std::size_t k = 1; k < fast.size(); ++k) {
    if (k % 4 != 0) fast[k].specific_force_imu = fast[k - 1].specific_force_imu;
  }
  EXPECT_TRUE(infinite(shown_range(fast))) << "read four times as often as measured";
}

TEST(ImuRange, WhatIsStatedCountsMoreThanWhatShows) {
  Recording r;
  r.imu = clipped(kRange);
  EXPECT_NEAR(range_of(r).accelerometer, kRange, 0.04);
  r.imu_range.accelerometer = 50;
  EXPECT_EQ(range_of(r).accelerometer, 50);
  EXPECT_TRUE(std::isinf(range_of(r).gyroscope));
}

TEST(ImuRange, IsWrittenAndReadBack) {
  const fs::path folder = test::scratch();
  Recording r = test::inertial();
  write_folder_recording(r, folder / "none");
  EXPECT_TRUE(std::isinf(read_folder_recording(folder / "none").imu_range.accelerometer));
  r.imu_range = {.accelerometer = 156.9064, .gyroscope = 1000 * M_PI / 180};
  write_folder_recording(r, folder / "both");
  const ImuRange read = read_folder_recording(folder / "both").imu_range;
  EXPECT_EQ(read.accelerometer, r.imu_range.accelerometer);
  EXPECT_EQ(read.gyroscope, r.imu_range.gyroscope);
  const std::string text = test::slurp(folder / "both/calibration.yaml");
  test::spill(folder / "both/calibration.yaml", text + "gyroscope_ranges: 3\n");
  expect_parts(input_error([&] { read_folder_recording(folder / "both"); }),
               {"'gyroscope_ranges': is unknown", "did you mean 'gyroscope_range'?"});
  r.imu_range.gyroscope = -1;
  write_folder_recording(r, folder / "bad");
  expect_parts(input_error([&] { read_folder_recording(folder / "bad"); }),
               {"key 'gyroscope_range': is -1, expected a positive number"});
}

// EuRoC's and KITTI's sensors never reach the limit of their range in these recordings.
TEST(ImuRange, RealRecordingsAreNotTakenForClipped) {
  const auto folder = test::recordings();
  if (!folder) GTEST_SKIP() << "skipped: no recordings";
  const fs::path euroc = *folder / ".." / "euroc";
  std::size_t read = 0;
  for (const auto& entry : fs::directory_iterator(euroc / "imu_gt")) {
    if (entry.path().filename().string().find("_imu.csv") == std::string::npos) continue;
    const ImuRange range = shown_range(read_recording(entry.path()).imu);
    EXPECT_TRUE(std::isinf(range.accelerometer)) << entry.path() << " " << range.accelerometer;
    EXPECT_TRUE(std::isinf(range.gyroscope)) << entry.path() << " " << range.gyroscope;
    ++read;
  }
  EXPECT_GE(read, 5u);
}

}  // namespace
}  // namespace chasles
