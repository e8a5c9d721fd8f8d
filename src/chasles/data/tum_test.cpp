#include <chasles/data/readers.hpp>
#include <chasles/data/testing.hpp>

namespace chasles {
namespace {

using test::expect_parts;
using test::input_error;

Trajectory read(const std::string& text) {
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
  const Trajectory t = read("0 1 2 3 0 0 0 1 9 9 9 9 9 9\n");
  EXPECT_EQ(t.at(0).pose.p, Eigen::Vector3d(1, 2, 3));
}

TEST(Tum, AQuarterTurnAboutTheVerticalTurnsForwardToLeft) {
  const Trajectory t = read("0 1 2 3 0 0 0.70710678 0.70710678\n");
  EXPECT_LT((t.at(0).pose.R * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 1e-9);
  EXPECT_EQ(t[0].pose.p, Eigen::Vector3d(1, 2, 3));
}

TEST(Tum, CommentsBlankLinesTabsCarriageReturnsAndExponentsAreTaken) {
  const Trajectory t = read(
      "# a comment\r\n\r\n  1317384506.402997001  1 2 3\t0 0 0 1 \r\n"
      "   # another\n1.3173845065e9 +1e0 2 3 0 0 0 1");
  ASSERT_EQ(t.size(), 2u);
  EXPECT_EQ(t[0].time.count(), 1317384506402997001);
  EXPECT_EQ(t[1].time.count(), 1317384506500000000);
  EXPECT_EQ(t[1].pose.p.x(), 1);
}

TEST(Tum, DecimalsBeyondANanosecondAreRounded) {
  EXPECT_EQ(read("1.0000000014 0 0 0 0 0 0 1").at(0).time.count(), 1000000001);
  EXPECT_EQ(read("1.0000000016 0 0 0 0 0 0 1").at(0).time.count(), 1000000002);
  EXPECT_EQ(read("1.9999999996 0 0 0 0 0 0 1").at(0).time.count(), 2000000000);
  EXPECT_EQ(read("3 0 0 0 0 0 0 1").at(0).time.count(), 3000000000);
}

TEST(Tum, ErrorsNameFileAndLine) {
  const std::string good = "1 0 0 0 0 0 0 1\n";
  const auto message = [&](const std::string& text) { return input_error([&] { read(text); }); };
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
  const Eigen::Matrix3d R = read("1 0 0 0 0 0 0.7071 0.7077\n").at(0).pose.R;
  EXPECT_LT((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), 1e-14);
}

TEST(Tum, AFolderThatIsMissingCannotBeWritten) {
  EXPECT_THROW(write_tum({}, "/no/such/folder/t.tum"), UsageError);
}

}  // namespace
}  // namespace chasles
