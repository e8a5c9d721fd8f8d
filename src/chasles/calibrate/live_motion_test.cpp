#include <cmath>
#include <filesystem>
#include <fstream>
#include <unistd.h>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chasles/calibrate/live_motion.hpp>

namespace chasles::test {
namespace {

namespace fs = std::filesystem;

// At 100 Hz: turns about x by 1 rad/s and about z by a tenth of that, and a force that changes
// along x and y.
std::string row(int i) {
  const double a = 0.1 * i;
  return fmt::format("{},{},{},{},{},{},9.8\n", 1'000'000'000 + 10'000'000LL * i, 0.5 + std::sin(a),
                     0.5 * std::cos(a), 0.1 * std::sin(a), std::sin(a), std::cos(a));
}

TEST(LiveMotion, SaysWhatTheTableLacksAsItGrows) {
  const fs::path folder = fs::temp_directory_path() / fmt::format("chasles_motion_{}", ::getpid());
  fs::remove_all(folder);
  LiveMotion motion(folder);
  motion.poll();
  EXPECT_EQ(motion.missing({}, {}).front(), "there are no samples of an IMU yet");
  fs::create_directories(folder / "cam0");
  std::ofstream table(folder / "imu.csv");
  table << "timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z\n1000" << std::flush;
  motion.poll();
  EXPECT_EQ(motion.samples(), 0u);
  table.close();
  std::string text = "timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z\n";
  for (int i = 0; i < 1000; ++i) text += row(i);
  std::ofstream(folder / "imu.csv") << text + row(1000).substr(0, 20);
  motion.poll();
  EXPECT_EQ(motion.samples(), 1000u) << "whole rows";
  // Of all samples, and of those of the views; the bias of 0.5 rad/s is no turn.
  for (const Time last : {Time(5), Time(9'000'000'000)}) {
    const std::vector<std::string> missing = motion.missing(Time(0), last);
    ASSERT_EQ(missing.size(), 2u);
    EXPECT_NE(missing[0].find("turns by 0.07 rad/s about the IMU's z axis"), std::string::npos)
        << missing[0];
    EXPECT_NE(missing[1].find("force along the IMU's z axis"), std::string::npos) << missing[1];
  }
  std::ofstream(folder / "imu.csv", std::ios::app) << row(1000).substr(20);
  motion.poll();
  EXPECT_EQ(motion.samples(), 1001u);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace chasles::test
