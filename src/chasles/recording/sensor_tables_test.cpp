#include <chasles/recording/image_testing.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/sensor_tables.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;

const char* const kCameraChain =
    "cam0:\n  T_cam_imu: [[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n"
    "  camera_model: pinhole\n  distortion_model: none\n  distortion_coeffs: []\n"
    "  intrinsics: [4, 4, 3.5, 2.5]\n  resolution: [8, 6]\n";
const char* const kNoise =
    "accelerometer_noise_density: 0.01\naccelerometer_random_walk: 0.0002\n"
    "gyroscope_noise_density: 0.005\ngyroscope_random_walk: 4.0e-06\n";

/// 30 rows of 5 ms, from `begin` [ns] on; `row` makes one of the time and the row's number.
template <typename Row>
std::string table(const std::string& head, const Row& row, std::int64_t begin = 0) {
  std::string text = head + "\n";
  for (int k = 0; k < 30; ++k) text += row(begin + k * 5'000'000LL, k) + "\n";
  return text;
}

/// A folder of images with tables of accelerometer and gyroscope. The force is (0.1, 0.2, 9.5 + k /
/// 1000), the rate (k / 100, -0.2, 0.3).
class SensorTablesFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = test::scratch() / "rec";
    fs::create_directories(folder / "images/cam0");
    test::spill(folder / "camchain-imucam.yaml", kCameraChain);
    test::spill(folder / "imu.yaml", kNoise);
    for (int k = 0; k < test::kFrames; ++k) {
      test::spill(folder / "images/cam0" / (test::stamp_of(k) + ".png"),
                  test::picture_bytes(test::shade_of(0, k)));
    }
  }
  void spill(const std::string& name, const std::string& text) {
    fs::create_directories((folder / name).parent_path());
    test::spill(folder / name, text);
  }
  void spill_plain(const std::string& accel, const std::string& gyro) {
    spill(accel, table("timestamp,ax,ay,az", [](std::int64_t t, int k) {
            return fmt::format("{},0.1,0.2,{}", t, 9.5 + 1e-3 * k);
          }));
    spill(gyro, table("timestamp,wx,wy,wz", [](std::int64_t t, int k) {
            return fmt::format("{},{},-0.2,0.3", t, 0.01 * k);
          }));
  }
  Recording expect_joined(std::size_t count = 30) {
    const Recording r = read_recording(folder);
    EXPECT_EQ(r.imu.size(), count);
    for (const ImuSample& s : r.imu) {
      const double k = to_seconds(s.time) / 0.005;
      EXPECT_LT((s.specific_force_imu - Eigen::Vector3d(0.1, 0.2, 9.5 + 1e-3 * k)).norm(), 1e-7);
      EXPECT_LT((s.angular_rate_imu - Eigen::Vector3d(0.01 * k, -0.2, 0.3)).norm(), 1e-7);
    }
    return r;
  }
  std::string rejection() const {
    return input_error([&] { read_recording(folder); });
  }
  fs::path folder;
};

TEST_F(SensorTablesFolder, TwoTablesAreAnImu) {
  spill_plain("accel.csv", "gyro.csv");
  const Recording r = expect_joined();
  ASSERT_FALSE(r.remarks.empty());
  expect_parts(r.remarks[0], {"accelerometer (accel.csv, 200 Hz)", "gyroscope (gyro.csv, 200 Hz)"});
  spill("imu.csv", "time_ns,wx,wy,wz,ax,ay,az\n" + test::five_samples());
  EXPECT_EQ(read_recording(folder).imu.size(), 5u) << "one table of both is preferred";
}

// Sensor Logger: z first; Accelerometer.csv is without gravity.
TEST_F(SensorTablesFolder, ThoseOfAPhoneAppAreReadByTheirColumns) {
  const auto app = [](const std::array<double, 3>& xyz, double step, std::size_t axis) {
    return [=](std::int64_t t, int k) {
      std::array<double, 3> v = xyz;
      v[axis] += step * k;
      return fmt::format("{},{:.6f},{},{},{}", t, 1e-9 * static_cast<double>(t), v[2], v[1], v[0]);
    };
  };
  const char* const head = "time,seconds_elapsed,z,y,x";
  spill("Gyroscope.csv", table(head, app({0, -0.2, 0.3}, 0.01, 0)));
  spill("Accelerometer.csv", table(head, app({0.1, 0.2, 0.1}, 0.001, 2)));
  expect_parts(rejection(),
               {"Accelerometer.csv: the median", "without gravity", "TotalAcceleration.csv"});
  spill("TotalAcceleration.csv", table(head, app({0.1, 0.2, 9.5}, 0.001, 2)));
  const Recording r = expect_joined();
  expect_parts(r.remarks.at(0), {"TotalAcceleration.csv is read, and Accelerometer.csv is not"});
}

TEST_F(SensorTablesFolder, UnitsInBracketsAndOtherSeparatorsAreRead) {
  spill("Gyroscope.csv",
        table("\"Time (s)\";\"X (deg/s)\";\"Y (deg/s)\";\"Z (deg/s)\"", [](std::int64_t t, int k) {
          return fmt::format("{:.9f};{:.9f};{:.9f};{:.9f}", 1e-9 * static_cast<double>(t),
                             0.01 * k * 180 / M_PI, -0.2 * 180 / M_PI, 0.3 * 180 / M_PI);
        }));
  spill("accelerometer.txt",
        "# accelerometer data\n" +
            table("# timestamp ax [g] ay [g] az [g]", [](std::int64_t t, int k) {
              return fmt::format("{:.6f} {:.12f}  {:.12f}\t{:.12f}", 1e-9 * static_cast<double>(t),
                                 0.1 / kStandardGravity, 0.2 / kStandardGravity,
                                 (9.5 + 1e-3 * k) / kStandardGravity);
            }));
  const Recording r = expect_joined();
  std::string all;
  for (const std::string& remark : r.remarks) all += remark + "\n";
  expect_parts(all, {"Gyroscope.csv is in deg/s: converted to rad/s",
                     "accelerometer.txt is in g: converted to m/s^2"});
}

TEST_F(SensorTablesFolder, OneSensorAloneIsNamed) {
  spill_plain("accel.csv", "gyro.csv");
  fs::remove(folder / "gyro.csv");
  expect_parts(rejection(), {"has accel.csv, but no table of the gyroscope and no imu.csv"});
  spill_plain("accel.csv", "gyro.csv");
  fs::remove(folder / "accel.csv");
  expect_parts(rejection(), {"has gyro.csv, but no table of the accelerometer"});
}

TEST_F(SensorTablesFolder, WhatATableLacksIsNamedWithItsColumns) {
  spill_plain("accel.csv", "gyro.csv");
  const auto with = [&](const std::string& head) {
    spill("gyro.csv", table(head, [](std::int64_t t, int) { return fmt::format("{},1,2,3", t); }));
    return rejection();
  };
  expect_parts(with("timestamp,wx,wy,temperature"), {"gyro.csv:1", "wx,wy", "no three"});
  expect_parts(with("row,wx,wy,wz"), {"none is a time"});
  expect_parts(with("time,wx [lsb],wy [lsb],wz [lsb]"), {"is lsb, expected rad/s or deg/s"});
  spill("accel.csv",
        table("time,x,y,z", [](std::int64_t t, int) { return fmt::format("{},0,0,1.01", t); }));
  spill_plain("unused.csv", "gyro.csv");
  expect_parts(rejection(), {"are they in g", "x (g)"});
}

TEST_F(SensorTablesFolder, EurocsLayoutMayHaveThemApart) {
  const fs::path rec = folder.parent_path() / "euroc";
  test::write_euroc_folder(rec, 1);
  fs::remove(rec / "mav0/imu0/data.csv");
  folder = rec / "mav0";
  expect_parts(input_error([&] { read_recording(rec); }), {"imu0/data.csv"});
  spill_plain("accel0/data.csv", "gyro0/data.csv");
  folder = rec;
  const Recording r = expect_joined();
  EXPECT_EQ(r.imu_noise->accelerometer_noise_density, 2e-3);
  expect_parts(r.remarks.at(0), {"accel0/data.csv", "gyro0/data.csv"});
}

// JavaScript writes 2 for 2.0: the unit is one for the whole column.
TEST_F(SensorTablesFolder, TheUnitOfTimesIsThatOfTheColumn) {
  const auto shortest = [](std::int64_t t) {
    return fmt::format("{}", 1e-9 * static_cast<double>(t));
  };
  spill("accel.csv", table("seconds_elapsed,x,y,z", [&](std::int64_t t, int k) {
          return fmt::format("{},0.1,0.2,{}", shortest(t), 9.5 + 1e-3 * k);
        }));
  spill("gyro.csv", table("t,x,y,z", [&](std::int64_t t, int k) {
          return fmt::format("{},{},-0.2,0.3", shortest(t), 0.01 * k);
        }));
  Recording r = expect_joined();
  expect_parts(r.remarks.at(0), {"accel.csv: the times are taken as seconds"});
  for (const char* head : {"timestamp [ns],x,y,z", "time_ns,x,y,z"}) {
    SCOPED_TRACE(head);
    spill("accel.csv", table(head, [](std::int64_t t, int k) {
            return fmt::format("{}.0,0.1,0.2,{}", t, 9.5 + 1e-3 * k);
          }));
    spill("gyro.csv", table(head, [](std::int64_t t, int k) {
            return fmt::format("{}.0,{},-0.2,0.3", t, 0.01 * k);
          }));
    expect_joined();
  }
}

TEST_F(SensorTablesFolder, WhatTheTableOfBothSensorsMayBeEachMayBe) {
  const auto both = [&](const std::string& name, const char* axes, double scale, auto value) {
    spill(name, table(axes, [=](std::int64_t t, int k) {
            const std::array<double, 3> v = value(k);
            std::string row =
                fmt::format("{},{};{};{};{}", t / 1000000000, fmt::format("{:09}", t % 1000000000),
                            v[0] / scale, v[1] / scale, v[2] / scale);
            std::ranges::replace(row, '.', ',');
            return row;
          }));
  };
  const auto force = [](int k) { return std::array<double, 3>{0.1, 0.2, 9.5 + 1e-3 * k}; };
  const auto rate = [](int k) { return std::array<double, 3>{0.01 * k, -0.2, 0.3}; };
  both("accel.csv", "time;ax_g;ay_g;az_g", kStandardGravity, force);
  both("gyro.csv", "Time (s);gyro_x_mdps;gyro_y_mdps;gyro_z_mdps", M_PI / 180e3, rate);
  expect_joined();
  spill("accel.csv", table("header.stamp.secs,header.stamp.nsecs,acceleration.x,acceleration.y,"
                           "acceleration.z",
                           [](std::int64_t t, int k) {
                             return fmt::format("{},{},0.1,0.2,{}", t / 1000000000, t % 1000000000,
                                                9.5 + 1e-3 * k);
                           }));
  expect_joined();
}

TEST_F(SensorTablesFolder, TheOtherSensorsAxesAreRejected) {
  spill_plain("gyro.csv", "accel.csv");
  expect_parts(rejection(), {"accel.csv:1", "wx, … are those of the gyroscope"});
  spill_plain("accel.csv", "gyro.csv");
  fs::copy_file(folder / "accel.csv", folder / "gyro.csv", fs::copy_options::overwrite_existing);
  expect_parts(rejection(), {"gyro.csv:1", "ax, … are those of the accelerometer"});
}

}  // namespace
}  // namespace chasles
