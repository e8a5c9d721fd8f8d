#include <chasles/recording/readers.hpp>
#include <chasles/recording/testing.hpp>
#include <chasles/recording/truth_table.hpp>

namespace chasles {
namespace {

using test::expect_parts;
using test::input_error;

Trajectory read_text(const std::string& text) {
  const auto file = test::scratch() / "t.tum";
  test::spill(file, text);
  return read_tum(file);
}

TEST(Tum, WhatIsWrittenIsReadAgain) {
  Trajectory trajectory;
  for (int k = 0; k < 50; ++k) {
    Vector6d twist;
    twist << 0.1 * k, -0.05 * k, 0.02 * k, 1.0 / (k + 1), 1e5 * k, -1e-9 * k;
    trajectory.push_back(
        {.time = Time(1317384506402997123 + 100'000'001LL * k), .pose = se3::exp(twist)});
  }
  const auto file = test::scratch() / "t.tum";
  write_tum(trajectory, file);
  const Trajectory again = read_tum(file);
  ASSERT_EQ(again.size(), trajectory.size());
  for (std::size_t k = 0; k < again.size(); ++k) {
    EXPECT_EQ(again[k].time, trajectory[k].time);
    EXPECT_EQ(again[k].pose.p, trajectory[k].pose.p);
    EXPECT_LT((again[k].pose.R - trajectory[k].pose.R).norm(), 1e-14);
  }
}

TEST(Tum, TimesBeforeZeroAreKept) {
  const auto file = test::scratch() / "t.tum";
  write_tum({{.time = Time(-1'500'000'001), .pose = {}}, {.time = Time(-5), .pose = {}}}, file);
  const Trajectory again = read_tum(file);
  EXPECT_EQ(again[0].time.count(), -1'500'000'001);
  EXPECT_EQ(again[1].time.count(), -5);
}

TEST(Tum, TheVariancesThatOpenVinsAppendsAreNotRead) {
  const Trajectory t = read_text("0 1 2 3 0 0 0 1 9 9 9 9 9 9\n");
  EXPECT_EQ(t.at(0).pose.p, Eigen::Vector3d(1, 2, 3));
}

TEST(Tum, AQuarterTurnAboutTheVerticalTurnsForwardToLeft) {
  const Trajectory t = read_text("0 1 2 3 0 0 0.70710678 0.70710678\n");
  EXPECT_LT((t.at(0).pose.R * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 1e-9);
  EXPECT_EQ(t[0].pose.p, Eigen::Vector3d(1, 2, 3));
}

TEST(Tum, CommentsBlankLinesTabsCarriageReturnsAndExponentsAreTaken) {
  const Trajectory t = read_text(
      "# a comment\r\n\r\n  1317384506.402997001  1 2 3\t0 0 0 1 \r\n"
      "   # another\n1.3173845065e9 +1e0 2 3 0 0 0 1");
  ASSERT_EQ(t.size(), 2u);
  EXPECT_EQ(t[0].time.count(), 1317384506402997001);
  EXPECT_EQ(t[1].time.count(), 1317384506500000000);
  EXPECT_EQ(t[1].pose.p.x(), 1);
}

TEST(Tum, DecimalsBeyondANanosecondAreRounded) {
  EXPECT_EQ(read_text("1.0000000014 0 0 0 0 0 0 1").at(0).time.count(), 1000000001);
  EXPECT_EQ(read_text("1.0000000016 0 0 0 0 0 0 1").at(0).time.count(), 1000000002);
  EXPECT_EQ(read_text("1.9999999996 0 0 0 0 0 0 1").at(0).time.count(), 2000000000);
  EXPECT_EQ(read_text("3 0 0 0 0 0 0 1").at(0).time.count(), 3000000000);
}

TEST(Tum, CommasAndAByteOrderMarkAreTaken) {
  const Trajectory t = read_text(
      "\xef\xbb\xbf# timestamp tx ty tz qx qy qz qw\n1.5,1,2,3,0,0,0,1\n"
      "2.5, 4, 5, 6, 0, 0, 0, 1\r\n");
  ASSERT_EQ(t.size(), 2u);
  EXPECT_EQ(t[0].time.count(), 1'500'000'000);
  EXPECT_EQ(t[1].pose.p, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(read_text("\xef\xbb\xbf"
                      "1.5 1 2 3 0 0 0 1")
                .at(0)
                .pose.p,
            Eigen::Vector3d(1, 2, 3));
}

TEST(Tum, TimesMayBeMilliMicroOrNanoseconds) {
  for (const char* time : {"1403636580.123456789", "1403636580123.456789", "1403636580123456.789",
                           "1403636580123456789", "1403636580123456789.000000"}) {
    EXPECT_EQ(read_text(std::string(time) + " 1 2 3 0 0 0 1").at(0).time.count(),
              1403636580123456789)
        << time;
  }
  EXPECT_EQ(read_text("-1403636580123456789 1 2 3 0 0 0 1").at(0).time.count(),
            -1403636580123456789);
  EXPECT_NEAR(static_cast<double>(read_text("1.403636580123e18 1 2 3 0 0 0 1").at(0).time.count()),
              1.403636580123e18, 1e3);
  // The unit that the first line names counts also for small times.
  EXPECT_EQ(read_text("#time_ns,x,y,z,qx,qy,qz,qw\n7,1,2,3,0,0,0,1\n").at(0).time.count(), 7);
}

TEST(Tum, ColumnsAreTakenByTheirNames) {
  const std::string half = "0.70710678";
  const std::string row = "1403636580000000000,1,2,3," + half + ",0,0," + half;
  const std::string names =
      "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], "
      "q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []";
  const Eigen::Vector3d left = Eigen::Vector3d::UnitY();
  for (const std::string& text :
       {names + "\n" + row + "\n",  // EuRoC's vicon0, and its states
        names + ", v_RS_R_x [m s^-1], v_RS_R_y [m s^-1]\r\n" + row + ",9,9\r\n",
        "time,px,py,pz,qw,qx,qy,qz\n" + row,
        "# t x y z q_w q_x q_y q_z\n1403636580 1 2 3 " + half + " 0 0 " + half + "\n"}) {
    const Trajectory t = read_text(text);
    ASSERT_EQ(t.size(), 1u) << text;
    EXPECT_EQ(t[0].time.count(), 1403636580000000000) << text;
    EXPECT_EQ(t[0].pose.p, Eigen::Vector3d(1, 2, 3)) << text;
    EXPECT_LT((t[0].pose.R * Eigen::Vector3d::UnitX() - left).norm(), 1e-8) << text;
  }
  // Names of TUM's columns with more words are a comment.
  EXPECT_EQ(read_text("# t tx ty tz qx qy qz qw of the IMU\n1 2 3 4 0 0 0 1").size(), 1u);
}

// sensor.yaml states where EuRoC's marker is on the body.
TEST(Tum, ThePoseOfAMarkerIsMovedToTheBody) {
  const auto folder = test::scratch();
  test::spill(folder / "data.csv",
              "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], "
              "q_RS_y [], q_RS_z []\n5,1,2,3,1,0,0,0\n");
  EXPECT_EQ(read_tum(folder / "data.csv").at(0).pose.p, Eigen::Vector3d(1, 2, 3));
  test::spill(folder / "sensor.yaml",
              "sensor_type: pose\nT_BS:\n  cols: 4\n  rows: 4\n  data: [0, -1, 0, 0.5, 1, 0, 0, 0, "
              "0, 0, 1, 0, 0, 0, 0, 1]\n");
  const SE3 body = read_tum(folder / "data.csv").at(0).pose;
  // The marker is 0.5 m in front of the body, turned to the left.
  EXPECT_LT((body * Eigen::Vector3d(0.5, 0, 0) - Eigen::Vector3d(1, 2, 3)).norm(), 1e-12);
  EXPECT_LT((body.R * Eigen::Vector3d::UnitY() - Eigen::Vector3d::UnitX()).norm(), 1e-12);
}

TEST(Tum, OtherTablesAreNamed) {
  const auto message = [&](const std::string& text) {
    return input_error([&] { read_text(text); });
  };
  const std::string leica = "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m]\n1,2,3,4\n";
  expect_parts(message(leica),
               {"t.tum:2: has 4 columns", "times and positions alone, as in EuRoC's leica0"});
  expect_parts(message("1 0 0 0 0 1 0 0 0 0 1 0\n"), {"t.tum:1: has 12", "KITTI's pose files?"});
  expect_parts(message("a,b,c\n1,2,3\n"), {"t.tum:1: has 3 columns"});
}

// The cases of ../shared/cases: the same poses in all of them.
TEST(Tum, TheSamePosesAreReadFromEveryForm) {
  const std::filesystem::path cases =
      std::filesystem::path(CHASLES_SOURCE_DIR) / ".." / "shared" / "cases" / "truth";
  if (!std::filesystem::exists(cases)) GTEST_SKIP() << "skipped: no cases";
  const Trajectory plain = read_tum(cases / "plain.tum");
  for (const char* file :
       {"byte_order_mark.tum", "commas.tum", "nanoseconds.tum", "euroc_states.csv", "mocap0.csv"}) {
    const Trajectory other = read_tum(cases / file);
    ASSERT_EQ(other.size(), plain.size()) << file;
    for (std::size_t i = 0; i < plain.size(); ++i) {
      EXPECT_EQ(other[i].time, plain[i].time) << file;
      EXPECT_EQ(other[i].pose.p, plain[i].pose.p) << file;
      EXPECT_EQ(other[i].pose.R, plain[i].pose.R) << file;
    }
  }
}

TEST(Tum, ErrorsNameFileAndLine) {
  const std::string good = "1 0 0 0 0 0 0 1\n";
  const auto message = [&](const std::string& text) {
    return input_error([&] { read_text(text); });
  };
  expect_parts(message(good + "2 0 0 0 0 0 1\n"), {"t.tum:2: has 7 columns, expected 8"});
  expect_parts(message(good + "\n2 0 0 0 0 0 0 1 9\n"), {"t.tum:3: has 9 columns, expected 8"});
  expect_parts(message("1 0 0 x 0 0 0 1\n"), {"t.tum:1: tz: found 'x', expected a number"});
  expect_parts(message("1 0 nan 0 0 0 0 1\n"), {"t.tum:1: ty: found 'nan', expected a finite"});
  expect_parts(message("1,0 0 0 0 0 0 0 1\n"), {"t.tum:1: t: found '1,0'"});
  expect_parts(message("1e30 0 0 0 0 0 0 1\n"), {"t.tum:1: t: found '1e30', expected seconds"});
  expect_parts(message("1 0 0 0 0 0 0 1.01\n"), {"t.tum:1: the quaternion", "length 1.01"});
  expect_parts(message("1 0 0 0 0 0 0 0\n"), {"t.tum:1: the quaternion", "length 0"});
  expect_parts(message(good + good), {"t.tum:2: the time 1.000000000", "rise strictly"});
  expect_parts(message("# nothing\n"), {"t.tum: holds no pose"});
  expect_parts(input_error([] { read_tum("/no/such.tum"); }), {"/no/such.tum: no such file"});
  expect_parts(input_error([] { read_tum("/tmp"); }), {"/tmp: is a folder"});
}

TEST(Tum, AQuaternionOfNearlyUnitLengthIsNormalised) {
  const Eigen::Matrix3d R = read_text("1 0 0 0 0 0 0.7071 0.7077\n").at(0).pose.R;
  EXPECT_LT((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), 1e-14);
}

TEST(Tum, AFolderThatIsMissingCannotBeWritten) {
  EXPECT_THROW(write_tum({}, "/no/such/folder/t.tum"), UsageError);
}

TEST(Tum, ATruthAsMotionCaptureWritesItIsMended) {
  const auto file = test::scratch() / "t.tum";
  test::spill(file,
              "3 3 0 0 0 0 0 1\n"
              "1 1 0 0 0 0 0 1\n"
              "1 9 0 0 0 0 0 1\n"
              "4 nan nan nan nan nan nan nan\n"
              "5 0 0 0 0 0 0 0\n"
              "2 2 0 0 0 0 0 1\n");
  std::vector<std::string> remarks;
  const Trajectory trajectory = read_tum(file, remarks);
  ASSERT_EQ(trajectory.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(trajectory[static_cast<std::size_t>(i)].time, std::chrono::seconds(i + 1));
    EXPECT_EQ(trajectory[static_cast<std::size_t>(i)].pose.p.x(), i + 1);
  }
  ASSERT_EQ(remarks.size(), 4u);
  EXPECT_EQ(remarks[0], "1 of 6 poses of t.tum are not finite numbers: left out");
  EXPECT_EQ(remarks[1], "1 of 6 poses of t.tum are lost (their quaternion is zero): left out");
  EXPECT_EQ(remarks[2], "3 of 4 poses of t.tum came after later ones: put in order of time");
  EXPECT_EQ(remarks[3], "1 of 4 poses of t.tum repeat the time of another: left out");
  test::spill(file, "4 nan nan nan nan nan nan nan\n");
  expect_parts(input_error([&] { read_tum(file, remarks); }), {"t.tum: none of the 1 poses"});
  test::spill(file, "4 1 1 1 2 0 0 0\n");
  expect_parts(input_error([&] { read_tum(file, remarks); }), {"t.tum:1: the quaternion"});
}

TEST(Tum, LostRowsAreCountedAsSuch) {
  const auto file = test::scratch() / "t.csv";
  test::spill(file,
              "frame_idx,timestamp,state,is_lost,is_keyframe,x,y,z,q_x,q_y,q_z,q_w\n"
              "0,0.1,2,false,false,1,2,3,0,0,0,1\n"
              "1,0.2,3,true,false,0,0,0,0,0,0,1\n"
              "2,0.3,3,false,false,0,0,0,0,0,0,0\n"
              "3,0.4,2,false,false,4,5,6,0,0,0,1\n");
  std::vector<std::string> remarks;
  const Trajectory trajectory = read_tum(file, remarks);
  ASSERT_EQ(trajectory.size(), 2u);
  EXPECT_EQ(trajectory[1].pose.p, Eigen::Vector3d(4, 5, 6));
  ASSERT_EQ(remarks.size(), 2u);
  EXPECT_EQ(remarks[0], "1 of 4 poses of t.csv are lost (their quaternion is zero): left out");
  EXPECT_EQ(remarks[1], "1 of 4 poses of t.csv are lost (is_lost): left out");
}

// One pose, a quarter turn to the left at (1, 2, 3), as other programs write it.
TEST(Tum, TablesOfOtherProgramsAreRead) {
  const std::string half = "0.70710678";
  const std::string pose = "1,2,3,0,0," + half + "," + half;
  const std::string ros =
      "position.x,P.position.y,P.position.z,P.orientation.x,P.orientation.y,"
      "P.orientation.z,P.orientation.w";
  const auto fields = [&](const std::string& prefix) {
    std::string text = "P." + ros;
    for (std::size_t at; (at = text.find("P.")) != std::string::npos;) {
      text.replace(at, 2, prefix);
    }
    return text;
  };
  const std::string ns = "1403636580000000000";
  for (const std::string& text :
       {"graph_uid,tracking_timestamp_us,utc_timestamp_ns,tx_world_device,ty_world_device,"
        "tz_world_device,qx_world_device,qy_world_device,qz_world_device,qw_world_device,"
        "gravity_x_world\nab-1,1403636580000000,-1," +
            pose + ",0\n",  // Aria's closed loop
        "tracking_timestamp_us,utc_timestamp_ns,session_uid,tx_odometry_device,"
        "ty_odometry_device,tz_odometry_device,qx_odometry_device,qy_odometry_device,"
        "qz_odometry_device,qw_odometry_device\n1403636580000000,-1,x," +
            pose + "\n",
        "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.child_frame_id," +
            fields("field.pose.pose.") + ",field.pose.covariance0\n99," + "1," + ns + ",map,imu," +
            pose + ",0.5\n",
        "%time,field.header.seq,field.header.stamp,field.header.frame_id," + fields("field.pose.") +
            "\n99,1," + ns + ",map," + pose + "\n",
        "%time," + fields("field.") + "\n" + ns + "," + pose + "\n",
        "# timestamp(s) q(4) p(3) v(3)\n1403636580 0 0 " + half + " " + half + " 1 2 3 0 0 0\n",
        "# timestamp(s) q p v bg ba cam_imu_dt\n1403636580 0 0 " + half + " " + half +
            " 1 2 3 0 0 0 0 0 0 0 0 0 0 0\n",
        std::string("\"time\";\"x\";\"y\";\"z\";\"qx\";\"qy\";\"qz\";\"qw\"\n"
                    "1403636580,0;1,0;2,0;3,0;0;0;0,70710678;0,70710678\n"),
        "1403636580 1 2 3 0 0 " + half + " " + half + " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1" +
            "\n"}) {
    const Trajectory t = read_text(text);
    ASSERT_EQ(t.size(), 1u) << text;
    EXPECT_EQ(t[0].time, std::chrono::seconds(1403636580)) << text;
    EXPECT_EQ(t[0].pose.p, Eigen::Vector3d(1, 2, 3)) << text;
    EXPECT_LT((t[0].pose.R * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 1e-8)
        << text;
  }
}

TEST(Tum, AQuaternionBeforeThePositionIsNamed) {
  expect_parts(input_error([] { read_text("1 0 0 0.6 0.8 5 6 7\n"); }),
               {"t.tum:1: ", "the quaternion comes before the position", "# t qx qy qz qw"});
}

TEST(TruthTable, PositionsAloneAreATruth) {
  const auto folder = test::scratch();
  std::vector<std::string> remarks;
  const auto table = [&](const std::string& name, const std::string& text) {
    test::spill(folder / name, text);
    remarks.clear();
    return read_truth_table(folder / name, remarks);
  };
  for (const std::string& text :
       {std::string("1 1 2 3\n2 4 5 6\n"), std::string("time,x,y,z\n1,1,2,3\n2,4,5,6\n"),
        std::string("1 1 2 3 0 0 0 0\n2 4 5 6 0 0 0 0\n")}) {
    const TruthTable positions = table("p.txt", text);
    EXPECT_FALSE(positions.attitudes) << text;
    ASSERT_EQ(positions.poses.size(), 2u) << text;
    EXPECT_EQ(positions.poses[1].pose.p, Eigen::Vector3d(4, 5, 6)) << text;
    EXPECT_TRUE(positions.poses[1].pose.R.isIdentity(0)) << text;
  }
  const TruthTable angles = table("e.txt", "# time x y z roll pitch yaw\n1 1 2 3 10 20 30\n");
  EXPECT_FALSE(angles.attitudes);
  ASSERT_EQ(remarks.size(), 1u);
  EXPECT_NE(remarks[0].find("Euler angles"), std::string::npos);
  EXPECT_TRUE(table("t.tum", "1 1 2 3 0 0 0 1\n2 0 0 0 0 0 0 0\n").attitudes);
  // EuRoC's prism is where its sensor.yaml has it.
  test::spill(folder / "sensor.yaml",
              "T_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, 0.07, 0, 1, 0, -0.02, 0, 0, 1, "
              "-0.12, 0, 0, 0, 1]\n");
  const TruthTable prism =
      table("data.csv", "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m]\n5,1,2,3\n");
  EXPECT_FALSE(prism.attitudes);
  EXPECT_EQ(prism.poses.at(0).time.count(), 5);
  EXPECT_EQ(prism.point_imu, Eigen::Vector3d(0.07, -0.02, -0.12));
}

}  // namespace
}  // namespace chasles
