#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>

#include <chasles/codec/bomb_testing.hpp>
#include <chasles/recording/imu_table.hpp>
#include <chasles/recording/testing.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;

// Samples at 200 Hz of a device that turns and is shaken, at times of 2014.
std::vector<ImuSample> shaken(std::size_t count) {
  std::vector<ImuSample> imu;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = 0.005 * static_cast<double>(i);
    imu.push_back(
        {.time = Time(1403636583263555584 + 4999936 * static_cast<std::int64_t>(i)),
         .specific_force_imu = {9.5 + std::sin(9 * t), std::cos(7 * t), 2 + std::sin(5 * t)},
         .angular_rate_imu = {std::sin(3 * t), 0.4 * std::cos(2 * t), 0.1 * t}});
  }
  return imu;
}

using Row = std::function<std::string(const ImuSample&)>;

std::string numbers(const ImuSample& s, double rate = 1, double force = 1,
                    const char* separator = ",") {
  const Eigen::Vector3d w = s.angular_rate_imu * rate, f = s.specific_force_imu * force;
  return fmt::format("{1}{0}{2}{0}{3}{0}{4}{0}{5}{0}{6}", separator, w.x(), w.y(), w.z(), f.x(),
                     f.y(), f.z());
}

std::string seconds_of(const ImuSample& s, int digits = 9) {
  const std::int64_t ns = s.time.count();
  return fmt::format(
      "{}.{}", ns / 1000000000,
      fmt::format("{:09}", ns % 1000000000).substr(0, static_cast<std::size_t>(digits)));
}

class ImuTableForms : public ::testing::Test {
 protected:
  void SetUp() override { file = test::scratch() / "imu.csv"; }
  void write(const std::string& heading, const Row& row) const {
    std::string text = heading;
    for (const ImuSample& s : truth) text += row(s) + "\n";
    test::spill(file, text);
  }
  // The largest differences from the samples that were written.
  void expect_read(const std::string& heading, const Row& row, Time most = Time(1),
                   const std::vector<std::string>& parts = {}) const {
    SCOPED_TRACE(heading);
    write(heading, row);
    std::vector<std::string> remarks;
    const std::vector<ImuSample> imu = read_imu_table(file, remarks);
    ASSERT_EQ(imu.size(), truth.size());
    for (std::size_t i = 0; i < imu.size(); ++i) {
      ASSERT_LE(std::abs((imu[i].time - truth[i].time).count()), most.count());
      ASSERT_TRUE(imu[i].angular_rate_imu.isApprox(truth[i].angular_rate_imu, 1e-9));
      ASSERT_TRUE(imu[i].specific_force_imu.isApprox(truth[i].specific_force_imu, 1e-9));
    }
    EXPECT_EQ(remarks.empty(), parts.empty()) << (remarks.empty() ? "" : remarks[0]);
    std::string all;
    for (const std::string& remark : remarks) all += remark + "\n";
    expect_parts(all, parts);
  }
  std::string rejected(const std::string& heading, const Row& row) const {
    write(heading, row);
    return input_error([&] { read_imu_table(file); });
  }

  fs::path file;
  std::vector<ImuSample> truth = shaken(200);
};

const char* const kNames = "time_ns,wx,wy,wz,ax,ay,az\n";

TEST_F(ImuTableForms, SeparatorsQuotesAndDecimalCommasAreFound) {
  const auto row = [](const char* separator) {
    return [separator](const ImuSample& s) {
      return fmt::format("{}{}{}", s.time.count(), separator, numbers(s, 1, 1, separator));
    };
  };
  expect_read("time_ns;wx;wy;wz;ax;ay;az\n", row(";"));
  expect_read("time_ns\twx\twy\twz\tax\tay\taz\n", row("\t"));
  expect_read("# time_ns wx wy wz ax ay az\n", row(" "));
  expect_read("# seven columns\n# time_ns wx wy wz ax ay az\n", row("   "));
  expect_read("# a table, in prose\n" + std::string(kNames), row(","), Time(0));
  expect_read("time_ns;wx;wy;wz;ax;ay;az;\n", [&](const ImuSample& s) {
    std::string text = row(";")(s) + ";";
    std::replace(text.begin(), text.end(), '.', ',');
    return text;
  });
  expect_read("\"time_ns\",\"wx\",\"wy\",\"wz\",\"ax\",\"ay\",\"az\",\"note, if any\"\n",
              [](const ImuSample& s) {
                return fmt::format("\"{}\",{},\"left, then right\"", s.time.count(), numbers(s));
              });
  test::spill(file, "\xff\xfet\0i\0m\0e\0");
  expect_parts(input_error([&] { read_imu_table(file); }), {"UTF-16", "UTF-8"});
}

TEST_F(ImuTableForms, UnitsBehindTheNamesAreApplied) {
  const double degrees = 180 / M_PI;
  const auto in = [](double rate, double force) {
    return [=](const ImuSample& s) {
      return fmt::format("{},{}", s.time.count(), numbers(s, rate, force));
    };
  };
  const std::vector<std::string> both{"angular rates in", "specific forces in", "converted"};
  expect_read("time_ns,gx(dps),gy(dps),gz(dps),ax(g),ay(g),az(g)\n", in(degrees, 1 / 9.80665),
              Time(0), both);
  expect_read("Timestamp[nanosec], wx [deg/s], wy [deg/s], wz [deg/s], ax [mg], ay [mg], az [mg]\n",
              in(degrees, 1e3 / 9.80665), Time(0), both);
  expect_read("time_ns,gyro_x_dps,gyro_y_dps,gyro_z_dps,acc_x_g,acc_y_g,acc_z_g\n",
              in(degrees, 1 / 9.80665), Time(0), both);
  expect_read(
      "time_ns,Gyroscope x (rad/s),Gyroscope y (rad/s),Gyroscope z (rad/s),"
      "Acceleration x (m/s^2),Acceleration y (m/s^2),Acceleration z (m/s^2)\n",
      in(1, 1));
  expect_read("timestampNs,gyroX,gyroY,gyroZ,accelX,accelY,accelZ\n", in(1, 1), Time(0));
  expect_parts(rejected("time_ns,wx [deg/s],wy [rad/s],wz,ax,ay,az\n", in(1, 1)),
               {"wx is in deg/s and wy in rad/s"});
}

TEST_F(ImuTableForms, TimesWithDecimalsAreSecondsAndTheirDigitsAreReported) {
  const auto digits = [](int count) {
    return [count](const ImuSample& s) { return seconds_of(s, count) + "," + numbers(s); };
  };
  const std::string names = "timestamp,wx,wy,wz,ax,ay,az\n";
  expect_read(names, digits(9), Time(0), {"imu.csv: the times are taken as seconds"});
  expect_read(names, digits(4), Time(100000),
              {"seconds", "steps of 0.1 ms", "rows are 5 ms apart"});
  expect_read("time [s],wx,wy,wz,ax,ay,az\n", digits(9), Time(0));
  expect_read("Time (s),wx,wy,wz,ax,ay,az\n", digits(4), Time(100000), {"steps of 0.1 ms"});
  expect_read(
      "timestamp_us,wx,wy,wz,ax,ay,az\n",
      [](const ImuSample& s) { return fmt::format("{},{}", s.time.count() / 1000, numbers(s)); },
      Time(1000));
  expect_parts(rejected(names, digits(0)), {"imu.csv:"});
  expect_parts(rejected(names, digits(1)),
               {"imu.csv:201", "steps of 100 ms", "200 rows are within 1 s", "with all digits"});
}

TEST_F(ImuTableForms, WhatSpreadsheetsRoundIsRejectedOrReported) {
  expect_parts(rejected(kNames,
                        [](const ImuSample& s) {
                          return fmt::format("{:.5E},{}", static_cast<double>(s.time.count()),
                                             numbers(s));
                        }),
               {"1.40364E+18", "steps of 10000 s", "spreadsheet", "Export the table again"});
  expect_read(kNames,
              [](const ImuSample& s) {
                return fmt::format("{},{}", s.time.count() / 10000 * 10000, numbers(s));
              },
              Time(10000), {"rounded to 15 digits", "10 us"});
  // All digits of a double, as pandas writes them.
  expect_read(
      kNames,
      [](const ImuSample& s) {
        return fmt::format("{:.16e},{}", static_cast<double>(s.time.count()), numbers(s));
      },
      Time(256));
}

TEST_F(ImuTableForms, TablesOfBagsAreRead) {
  std::string zeros = "0,0,0,0,0,0,0,0,0";
  const auto split = [&](const ImuSample& s) {
    return fmt::format("{},{}", s.time.count() / 1000000000, s.time.count() % 1000000000);
  };
  expect_read(
      "",
      [&](const ImuSample& s) {  // ros2 topic echo --csv
        const Eigen::Vector3d &w = s.angular_rate_imu, &f = s.specific_force_imu;
        return fmt::format("{},imu,0,0,0,1,{},{},{},{},{},{},{},{},{}", split(s), zeros, w.x(),
                           w.y(), w.z(), zeros, f.x(), f.y(), f.z(), zeros);
      },
      Time(0));
  expect_read(
      "Time,header.seq,header.stamp.secs,header.stamp.nsecs,header.frame_id,orientation.x,"
      "angular_velocity.x,angular_velocity.y,angular_velocity.z,linear_acceleration.x,"
      "linear_acceleration.y,linear_acceleration.z\n",
      [&](const ImuSample& s) {  // bagpy; Time is that of recording
        return fmt::format("{:.3f},7,{},imu,0,{}", to_seconds(s.time) + 0.02, split(s), numbers(s));
      },
      Time(0));
  expect_read(
      "__time,/imu/angular_velocity/x,/imu/angular_velocity/y,/imu/angular_velocity/z,"
      "/imu/linear_acceleration/x,/imu/linear_acceleration/y,/imu/linear_acceleration/z\n",
      [](const ImuSample& s) { return seconds_of(s) + "," + numbers(s); }, Time(0), {"seconds"});
  expect_parts(rejected("header.stamp.secs,header.stamp.nsecs,wx,wy,wz,ax,ay,az\n",
                        [](const ImuSample& s) { return "1403636583,1000000000," + numbers(s); }),
               {"imu.csv:2", "below 1000000000"});
}

// A phone's fused motion: accelerations without gravity, beside the direction of gravity.
TEST_F(ImuTableForms, GravityThatWasRemovedIsNamed) {
  const auto fused = [](const ImuSample& s) {
    const Eigen::Vector3d up = s.specific_force_imu.normalized(),
                          a = s.specific_force_imu / 9.80665 - up, w = s.angular_rate_imu;
    return fmt::format("{},{},{},{},{},{},{},{},{},{}", s.time.count(), a.x(), a.y(), a.z(), w.x(),
                       w.y(), w.z(), -up.x(), -up.y(), -up.z());
  };
  expect_parts(
      rejected("timestamp, ax, ay, az, rx, ry, rz, gx, gy, gz\n", fused),
      {"gravity is removed from ax, ay, az", "gx, gy, gz", "direction of gravity", "9.81 m/s^2"});
  expect_parts(rejected("timestamp, ax, ay, az, wx, wy, wz, nx, ny, nz\n", fused),
               {"gravity is removed from ax, ay, az"});
  expect_parts(rejected("timestamp,qx,qy,qz,ax,ay,az,gx,gy,gz\n",
                        [&](const ImuSample& s) {
                          const Eigen::Vector3d f = s.specific_force_imu, up = f.normalized();
                          return fmt::format("{},0,0,0,{},{},{},{},{},{}", s.time.count(), f.x(),
                                             f.y(), f.z(), up.x(), up.y(), up.z());
                        }),
               {"gx, gy, gz have the length 1.000", "no angular rates"});
}

TEST_F(ImuTableForms, ExchangedAndEmptyColumnsAreNamed) {
  const auto numbers_of = [](const ImuSample& s, double a, double w, bool exchanged) {
    const Eigen::Vector3d f = a * s.specific_force_imu, g = w * s.angular_rate_imu;
    const Eigen::Vector3d &first = exchanged ? f : g, &second = exchanged ? g : f;
    return fmt::format("{},{},{},{},{},{},{}", s.time.count(), first.x(), first.y(), first.z(),
                       second.x(), second.y(), second.z());
  };
  const char* const head = "timestamp,wx,wy,wz,ax,ay,az\n";
  expect_parts(rejected(head, [&](const ImuSample& s) { return numbers_of(s, 1, 1, true); }),
               {"accelerometer and gyroscope are exchanged", "wx, wy, wz", "is gravity"});
  expect_parts(rejected(head, [&](const ImuSample& s) { return numbers_of(s, 0, 0, false); }),
               {"all six columns", "are 0 in all", "attitude alone"});
  expect_parts(rejected(head, [&](const ImuSample& s) { return numbers_of(s, 0, 1, false); }),
               {"ax, ay, az are 0 in all", "accelerometer was not read"});
}

// With gravity in them, the forces are read, and gx, gy, gz are not taken for rates.
TEST_F(ImuTableForms, GravityBesideRawForcesIsLeftOut) {
  const auto row = [](const ImuSample& s) {
    const Eigen::Vector3d g = 9.81 * s.specific_force_imu.normalized();
    return fmt::format("{},{},{},{},{}", s.time.count(), numbers(s), g.x(), g.y(), g.z());
  };
  expect_read("timestamp,rx,ry,rz,ax,ay,az,gx,gy,gz\n", row, Time(0),
              {"gx, gy, gz are the direction of gravity"});
  expect_read("timestamp,wx,wy,wz,ax,ay,az,gx,gy,gz\n", row, Time(0), {"direction of gravity"});
  expect_parts(rejected("timestamp,wx,wy,wz,ax,ay,az,gx,gy,gz\n",
                        [](const ImuSample& s) {
                          return fmt::format("{},{},{},0,0", s.time.count(), numbers(s),
                                             s.angular_rate_imu.x());
                        }),
               {"both wx, wy, wz and gx, gy, gz may be the angular rates"});
}

TEST_F(ImuTableForms, TheOnlyTableOfAFolderIsFound) {
  const auto row = [](const ImuSample& s) {
    return fmt::format("{},{}", s.time.count(), numbers(s));
  };
  const fs::path folder = file.parent_path();
  write(kNames, row);
  fs::rename(file, folder / "gyro_accel.csv");
  test::spill(folder / "notes.txt", "time, and more\n1,2\n");
  std::vector<std::string> remarks;
  EXPECT_EQ(find_imu_table(folder, remarks), folder / "gyro_accel.csv");
  ASSERT_EQ(remarks.size(), 1u);
  expect_parts(remarks[0], {"gyro_accel.csv", "no imu.csv"});
  fs::copy_file(folder / "gyro_accel.csv", folder / "second.txt");
  expect_parts(input_error([&] { find_imu_table(folder, remarks); }),
               {"gyro_accel.csv and", "second.txt", "name the right one imu.csv"});
  write(kNames, row);
  EXPECT_EQ(find_imu_table(folder, remarks), file);
}

TEST_F(ImuTableForms, AStatedUnitOfTimesCountsWhateverTheirDigits) {
  const auto since_start = [&](const ImuSample& s) {
    return fmt::format("{}.0,{}", (s.time - truth.front().time).count(), numbers(s));
  };
  for (ImuSample& s : truth) s.time -= Time(1403636583263555584 - 1000);
  for (const char* name : {"timestamp [ns]", "time_ns", "time (nanoseconds)"}) {
    const std::string heading = std::string(name) + ",wx,wy,wz,ax,ay,az\n";
    write(heading, since_start);
    const std::vector<ImuSample> imu = read_imu_table(file);
    ASSERT_EQ(imu.size(), truth.size());
    EXPECT_EQ(imu.back().time, truth.back().time - truth.front().time) << name;
  }
  for (const char* name : {"#timestamp [ns]", "time_ns"}) {  // which cannot be
    expect_read(std::string(name) + ",wx,wy,wz,ax,ay,az\n",
                [](const ImuSample& s) { return seconds_of(s) + "," + numbers(s); }, Time(1),
                {"imu.csv: the times are taken as seconds"});
  }
  expect_parts(rejected("time (min),wx,wy,wz,ax,ay,az\n", since_start),
               {"the unit of time is min"});
}

TEST_F(ImuTableForms, TabsAfterCommasAndDecimalCommasBetweenBlanksAreFound) {
  const auto row = [](const char* separator) {
    return [separator](const ImuSample& s) {
      return fmt::format("{}{}{}", s.time.count(), separator, numbers(s, 1, 1, separator));
    };
  };
  expect_read("#timestamp [ns],w_RS_S_x,w_RS_S_y,w_RS_S_z,a_RS_S_x,a_RS_S_y,a_RS_S_z\n",
              row(",\t"));
  expect_read("time_ns,\twx,\twy,\twz,\tax,\tay,\taz\n", row(" ,\t "));
  const auto comma = [&](const char* separator, char quote) {
    return [=](const ImuSample& s) {
      std::string text = row(separator)(s);
      std::replace(text.begin(), text.end(), '.', ',');
      if (quote == 0) return text;
      std::string quoted = "\"";
      for (const char c : text) quoted += c == '|' ? "\",\"" : std::string(1, c);
      return quoted + "\"";
    };
  };
  expect_read("time_ns wx wy wz ax ay az\n", comma("  ", 0));
  expect_read("# time_ns wx wy wz ax ay az\n", comma("\t ", 0));
  expect_read("\"time_ns\",\"wx\",\"wy\",\"wz\",\"ax\",\"ay\",\"az\"\n", comma("|", '"'));
  expect_read("# time_ns, wx, wy, wz, ax, ay, az\n", row(" "));
  expect_read("time_ns,wx,wy,wz,ax,ay,az\n", row("\t"));
  expect_read("time, ns\twx\twy\twz\tax\tay\taz\n", comma("\t", 0));
  expect_read("sep=;\r\ntime_ns;wx;wy;wz;ax;ay;az\r\n", comma(";", 0));
}

TEST_F(ImuTableForms, ALineOfUnitsBelowTheNamesCounts) {
  const auto row = [](const ImuSample& s) {
    return seconds_of(s) + "," + numbers(s, 180 / M_PI, 1 / 9.80665);
  };
  const std::vector<std::string> parts{"angular rates in deg/s", "specific forces in g"};
  for (const char* units : {"s,deg/s,deg/s,deg/s,g,g,g", "# s,deg/s,deg/s,deg/s,g,g,g",
                            "[s],[deg/s],[deg/s],[deg/s],[g],[g],[g]", "\n(s),deg/s,,,g,,"}) {
    expect_read(fmt::format("time,wx,wy,wz,ax,ay,az\n{}\n", units), row, Time(0), parts);
  }
  expect_read(
      "# time wx wy wz ax ay az\n# [s] [deg/s] [deg/s] [deg/s] [g] [g] [g]\n",
      [](const ImuSample& s) {
        return seconds_of(s) + " " + numbers(s, 180 / M_PI, 1 / 9.80665, " ");
      },
      Time(0), parts);
  expect_read("time,wx,wy,wz,ax,ay,az\n# units: s, deg/s, deg/s, deg/s, g, g, g\n", row, Time(0),
              parts);
  expect_parts(rejected("time,wx,wy,wz,ax,ay,az\ns,counts,counts,counts,g,g,g\n", row),
               {"the unit of wx is counts"});
}

TEST_F(ImuTableForms, UnitsInOtherSpellingsAreKnownAndOthersAreRejected) {
  const auto read = [&](const std::string& rate, const std::string& force, double w, double f) {
    const std::vector<std::string> parts =
        w == 1 && f == 1 ? std::vector<std::string>{} : std::vector<std::string>{"converted"};
    expect_read(
        fmt::format("time_ns,wx [{0}],wy [{0}],wz [{0}],ax [{1}],ay [{1}],az [{1}]\n", rate, force),
        [=](const ImuSample& s) { return fmt::format("{},{}", s.time.count(), numbers(s, w, f)); },
        Time(0), parts);
  };
  for (const char* si : {"m/s2", "m/s^2", "m/s²", "m s^-2", "m·s⁻²", "m/s**2", "m/sec^2",
                         "meters per second squared", "m/s/s"}) {
    read("rad/s", si, 1, 1);
  }
  for (const char* si : {"rad/s", "rad s^-1", "rad·s⁻¹", "radians per second", "rad/sec", "1/s"}) {
    read(si, "m/s^2", 1, 1);
  }
  const double degrees = 180 / M_PI;
  for (const char* unit : {"deg/s", "°/s", "deg·s⁻¹", "degrees per second", "deg per s", "dps"}) {
    read(unit, "G-force", degrees, 1 / 9.80665);
  }
  read("urad/s", "cm/s2", 1e6, 100);
  read("rev/s", "ft/s2", 1 / (2 * M_PI), 1 / 0.3048);
  read("mdps", "milli-g", 1e3 * degrees, 1e3 / 9.80665);
  const auto si = [](const ImuSample& s) {
    return fmt::format("{},{}", s.time.count(), numbers(s));
  };
  for (const char* unit : {"furlongs", "lsb", "s", "m"}) {
    expect_parts(rejected(fmt::format("time_ns,wx,wy,wz,ax ({0}),ay ({0}),az ({0})\n", unit), si),
                 {"imu.csv:1", fmt::format("the unit of ax is {}", unit), "cm/s^2", "convert it",
                  "remove the brackets"});
  }
  expect_read("time_ns,wx (imu0),wy (imu0),wz (imu0),ax,ay,az\n", si, Time(0));
  expect_read("time_ns,Gyro X-axis,Gyro Y-axis,Gyro Z-axis,ax (body frame),ay,az\n", si, Time(0));
  expect_read("time_ns,gyro_x_mdps,gyro_y_mdps,gyro_z_mdps,acc_x_ug,acc_y_ug,acc_z_ug\n",
              [&](const ImuSample& s) {
                return fmt::format("{},{}", s.time.count(),
                                   numbers(s, 1e3 * degrees, 1e6 / 9.80665));
              },
              Time(0), {"mdps", "ug"});
  expect_read("time_ns,wx,wy,wz,gFx,gFy,gFz\n",  // Physics Toolbox
              [&](const ImuSample& s) {
                return fmt::format("{},{}", s.time.count(), numbers(s, 1, 1 / 9.80665));
              },
              Time(0), {"specific forces in g"});
}

TEST_F(ImuTableForms, RatesNamedGAreReadBesideDerivedOnes) {
  for (const char* other : {"est_gyro_x,est_gyro_y,est_gyro_z", "rx,ry,rz",
                            "true_angular_velocity_x,true_angular_velocity_y,"
                            "true_angular_velocity_z"}) {
    expect_read(
        fmt::format("time_ns,gx,gy,gz,ax,ay,az,{}\n", other),
        [](const ImuSample& s) { return fmt::format("{},{},1,2,3", s.time.count(), numbers(s)); },
        Time(0), {"the angular rates are gx, gy, gz", "are not read"});
  }
}

TEST_F(ImuTableForms, OfTwoTimesTheFirstOfTheListIsReadWithARemark) {
  expect_read(
      "time,timestamp,wx,wy,wz,ax,ay,az\n",
      [](const ImuSample& s) { return fmt::format("7.5,{},{}", s.time.count(), numbers(s)); },
      Time(0), {"the times are those of timestamp, and time is not read"});
}

TEST_F(ImuTableForms, ACompressedTableIsFound) {
  const auto row = [](const ImuSample& s) {
    return fmt::format("{},{}", s.time.count(), numbers(s));
  };
  const fs::path folder = file.parent_path();
  std::vector<std::string> remarks;
  write(kNames, row);
  test::spill(folder / "imu.csv.gz", test::gzipped(test::slurp(file)));
  EXPECT_EQ(find_imu_table(folder, remarks), file) << "the plain one";
  fs::rename(file, folder / "walk.csv");
  EXPECT_EQ(find_imu_table(folder, remarks), folder / "imu.csv.gz");
  EXPECT_EQ(read_imu_table(folder / "imu.csv.gz").size(), truth.size());
  fs::rename(folder / "imu.csv.gz", folder / "walk.csv.gz");
  EXPECT_EQ(find_imu_table(folder, remarks), folder / "walk.csv");
  fs::remove(folder / "walk.csv");
  EXPECT_EQ(find_imu_table(folder, remarks), folder / "walk.csv.gz");
  fs::remove(folder / "walk.csv.gz");
  test::spill(folder / "imu.csv.xz", "x");
  expect_parts(input_error([&] { find_imu_table(folder, remarks); }), {"`unxz imu.csv.xz`"});
}

TEST_F(ImuTableForms, ThoseOfPhoneAppsAndLoggersAreRead) {
  const double degrees = 180 / M_PI, g = 1 / 9.80665;
  const auto forces = [](const ImuSample& s, double factor) {
    const Eigen::Vector3d f = s.specific_force_imu * factor;
    return fmt::format("{},{},{}", f.x(), f.y(), f.z());
  };
  const auto rates = [](const ImuSample& s, double factor) {
    const Eigen::Vector3d w = s.angular_rate_imu * factor;
    return fmt::format("{},{},{}", w.x(), w.y(), w.z());
  };
  expect_read(  // AndroSensor
      "ACCELEROMETER X (m/s²),ACCELEROMETER Y (m/s²),ACCELEROMETER Z (m/s²),GRAVITY X (m/s²),"
      "LINEAR ACCELERATION X (m/s²),LINEAR ACCELERATION Y (m/s²),LINEAR ACCELERATION Z (m/s²),"
      "GYROSCOPE X (rad/s),GYROSCOPE Y (rad/s),GYROSCOPE Z (rad/s),Time since start in ms ,DATE\n",
      [&](const ImuSample& s) {
        const std::int64_t ns = s.time.count();
        return fmt::format("{},0,1,2,3,{},{}.{:06},2014-06-24 19:03:03:263", forces(s, 1),
                           rates(s, 1), ns / 1000000, ns % 1000000);
      },
      Time(0));
  expect_read(  // SensorLog
      "loggingTime(txt),accelerometerTimestamp_sinceReboot(s),accelerometerAccelerationX(G),"
      "accelerometerAccelerationY(G),accelerometerAccelerationZ(G),gyroRotationX(rad/s),"
      "gyroRotationY(rad/s),gyroRotationZ(rad/s)\n",
      [&](const ImuSample& s) {
        return fmt::format("2014-06-24,{},{},{}", seconds_of(s), forces(s, g), rates(s, 1));
      },
      Time(0), {"specific forces in g"});
  expect_read("time_ns,gyro_dps_x,gyro_dps_y,gyro_dps_z,acc_g_x,acc_g_y,acc_g_z,\n",
              [&](const ImuSample& s) {
                return fmt::format("{},{},{}", s.time.count(), rates(s, degrees), forces(s, g));
              },
              Time(0), {"dps", "in g"});
  expect_read("% time [ns] wx [\xb0/s] wy [\xb0/s] wz [\xb0/s] ax [m/s\xb2] ay az\n",
              [&](const ImuSample& s) {
                return fmt::format("{} {}", s.time.count(), numbers(s, degrees, 1, " "));
              },
              Time(0), {"angular rates in"});
  expect_parts(rejected("time [ms],wx,wy,wz,ax,ay,az\n",
                        [](const ImuSample& s) { return seconds_of(s) + "," + numbers(s); }),
               {"imu.csv:2", "states milliseconds", "at 2e+05 Hz", "Correct the unit"});
}

}  // namespace
}  // namespace chasles
