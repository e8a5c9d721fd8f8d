#include <chasles/codec/bomb_testing.hpp>
#include <chasles/recording/imu_table.hpp>
#include <chasles/recording/testing.hpp>

namespace chasles {
namespace {

using test::expect_parts;
using test::input_error;

std::vector<ImuSample> read(const std::string& text) {
  const auto file = test::scratch() / "imu.csv";
  test::spill(file, text);
  return read_imu_table(file);
}

std::string error(const std::string& text) {
  return input_error([&] { read(text); });
}

void expect_sample(const std::string& text) {
  SCOPED_TRACE(text);
  const std::vector<ImuSample> imu = read(text);
  ASSERT_EQ(imu.size(), 1u);
  EXPECT_EQ(imu[0].time, std::chrono::milliseconds(1500));
  EXPECT_EQ(imu[0].angular_rate_imu, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(imu[0].specific_force_imu, Eigen::Vector3d(4, 5, 6));
}

TEST(ImuTable, IsReadByTheNamesOfItsColumns) {
  expect_sample("time_ns,wx,wy,wz,ax,ay,az\n1500000000,1,2,3,4,5,6\n");
  expect_sample(
      "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
      "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n1500000000,1,2,3,4,5,6\n");
  expect_sample(
      "timestamp,omega_x,omega_y,omega_z,alpha_x,alpha_y,alpha_z\n1500000000,1,2,3,4,5,6\n");
  expect_sample(
      "t,accel_x,accel_y,accel_z,gyro_x,gyro_y,gyro_z,temperature\n"
      "1500000000,4,5,6,1,2,3,36.6\n");
  expect_sample(
      "%time,field.header.seq,field.header.stamp,field.header.frame_id,"
      "field.orientation.x,field.angular_velocity.x,field.angular_velocity.y,"
      "field.angular_velocity.z,field.linear_acceleration.x,"
      "field.linear_acceleration.y,field.linear_acceleration.z\n"
      "9,7,1500000000,imu,0,1,2,3,4,5,6\n");
}

TEST(ImuTable, TimesAreInTheUnitOfTheirColumn) {
  expect_sample("timestamp [s],wx,wy,wz,ax,ay,az\n1.5,1,2,3,4,5,6\n");
  expect_sample("timestamp [ms],wx,wy,wz,ax,ay,az\n1500,1,2,3,4,5,6\n");
  expect_sample("timestamp [us],wx,wy,wz,ax,ay,az\n1500000,1,2,3,4,5,6\n");
  expect_parts(error("t [h],wx,wy,wz,ax,ay,az\n1,1,2,3,4,5,6\n"),
               {"imu.csv:1", "the unit of t is h", "ns, us, ms or s"});
  expect_parts(error("t [ms],wx,wy,wz,ax,ay,az\n9000000000000000000,1,2,3,4,5,6\n"), {"imu.csv:2"});
  for (const char* unit : {"us", "ms"}) {
    expect_parts(error(std::string("t [") + unit +
                       "],wx,wy,wz,ax,ay,az\n-9223372036854775808,1,2,3,4,5,6\n"),
                 {"imu.csv:2", "is -9223372036854775808"});
  }
  expect_sample("t,wx,wy,wz,ax,ay,az\n1.5,1,2,3,4,5,6\n");  // decimals are seconds
  expect_parts(error("t,wx,wy,wz,ax,ay,az\n1.5,1,2,3,4,5,6\nsoon,1,2,3,4,5,6\n"),
               {"imu.csv:3", "'t'", "soon", "expected a time in seconds"});
}

TEST(ImuTable, MayComeFromWindowsAndFromScripts) {
  expect_sample("\xef\xbb\xbftime_ns,wx,wy,wz,ax,ay,az\r\n1500000000,1,2,3,4,5,6\r\n");
  expect_sample("\xef\xbb\xbf#timestamp [ns],wx,wy,wz,ax,ay,az\n1500000000,1,2,3,4,5,6");
  expect_sample(
      "# recorded on the roof\n\n# time_ns, wx, wy, wz, ax, ay, az\n"
      "1500000000, 1, 2, 3, 4, 5, 6");
}

// As a robot that lost its power leaves it.
TEST(ImuTable, ATornLastLineIsLeftOut) {
  const std::string whole = "time_ns,wx,wy,wz,ax,ay,az\n1500000000,1,2,3,4,5,6\n";
  for (const char* torn :
       {"1600000000,1,2,3,4,5", "1600000000,1,2,3,4,5,-", "16", "1,1,1,1,1,1,9."}) {
    expect_sample(whole + torn);
  }
  expect_parts(error(whole + "1600000000,1,2,3,4,5\n"), {"imu.csv:3", "6 values, expected 7"});
  expect_parts(error(whole + "1,2,3,4,5,6,7,8"), {"imu.csv:3", "8 values, expected 7"});
}

TEST(ImuTable, ALineOfCommasIsNoTable) {
  const test::BombStopwatch quick;
  const std::string commas(30'000'000, ',');
  expect_parts(error("time_ns,wx,wy,wz,ax,ay,az\n" + commas + "\n"), {"imu.csv:2", "expected 7"});
  EXPECT_LT(error(commas + "\n").size(), 5000u);
}

TEST(ImuTable, AmbiguousNamesAreRejectedAtTheirLine) {
  expect_parts(error("1500000000,1,2,3,4,5,6\n"),
               {"imu.csv:1", "begins with '1500000000,1", "names of the columns"});
  expect_parts(error("time_ns,x1,x2,x3,ax,ay,az\n1,1,2,3,4,5,6\n"),
               {"imu.csv:1", "x1,x2,x3", "time_ns,wx,wy,wz,ax,ay,az"});
  expect_parts(error("wx,wy,wz,ax,ay,az\n1,2,3,4,5,6\n"), {"imu.csv:1", "none is the time"});
  expect_parts(error("time_ns,wx,wy,wz,ax,ay,az,acc_x\n1,1,2,3,4,5,6,7\n"),
               {"imu.csv:1", "both ax and acc_x"});
  expect_parts(error("time_ns,wx [lsb],wy,wz,ax,ay,az\n1,1,2,3,4,5,6\n"),
               {"imu.csv:1", "the unit of wx is lsb", "expected rad/s"});
  expect_parts(error("time_ns,gx(g),gy(g),gz(g),ax,ay,az\n1,1,2,3,4,5,6\n"),
               {"the unit of gx is g", "expected rad/s"});
  expect_parts(error("time_ns,wx,wy,wz,ax [dps],ay,az\n1,1,2,3,4,5,6\n"),
               {"the unit of ax is dps", "expected m/s^2 or g"});
  expect_parts(error(""), {"imu.csv", "names of the columns"});
  expect_parts(error("time_ns,wx,wy,wz,ax,ay,az\n1,1,2,3,4,five,6\n"),
               {"imu.csv:2", "'ay'", "five"});
}

}  // namespace
}  // namespace chasles
