#include <bit>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/target/marker_dictionary.hpp>
#include <chasles/target/tag_layout.hpp>
#include <chasles/target/target_file.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

const std::string kAprilGridYaml =
    "target_type: 'aprilgrid' #gridtype\n"
    "tagCols: 6               #number of apriltags\n"
    "tagRows: 6               #number of apriltags\n"
    "tagSize: 0.088           #size of apriltag, edge to edge [m]\n"
    "tagSpacing: 0.3          #ratio of space between tags to tagSize\n";
const std::string kCheckerboardYaml =
    "target_type: 'checkerboard'\ntargetCols: 6\ntargetRows: 7\nrowSpacingMeters: 0.06\n"
    "colSpacingMeters: 0.05\n";
const std::string kCharucoYaml =
    "target_type: charuco\nsquaresX: 5\nsquaresY: 8\nsquareLength: 0.04\nmarkerLength: 0.03\n"
    "dictionary: DICT_5X5_100\nlegacy_pattern: true\n";

fs::path written(const std::string& text) {
  const fs::path file = fs::path(testing::TempDir()) / "target.yaml";
  std::ofstream(file) << text;
  return file;
}

// The text with `from` as `to`.
std::string changed(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

void expect_error(const std::string& text, const std::vector<std::string>& parts) {
  try {
    read_target(written(text));
    ADD_FAILURE() << "no error for\n" << text;
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("target.yaml"), std::string::npos) << message;
    for (const std::string& part : parts) {
      EXPECT_NE(message.find(part), std::string::npos) << message << "\nmisses " << part;
    }
  }
}

TEST(TargetFile, KalibrsFilesAreRead) {
  EXPECT_EQ(read_target(written(kAprilGridYaml)), (Target{.kind = TargetKind::april_grid,
                                                          .columns = 6,
                                                          .rows = 6,
                                                          .tag_size = 0.088,
                                                          .tag_spacing = 0.3}));
  EXPECT_EQ(read_target(written(kCheckerboardYaml)), (Target{.kind = TargetKind::checkerboard,
                                                             .columns = 6,
                                                             .rows = 7,
                                                             .column_spacing = 0.05,
                                                             .row_spacing = 0.06}));
}

TEST(TargetFile, WhatIsWrittenIsRead) {
  for (const std::string& text : {kAprilGridYaml, kCheckerboardYaml, kCharucoYaml}) {
    const Target target = read_target(written(text));
    EXPECT_EQ(read_target(written(target_yaml(target))), target) << text;
  }
  const fs::path file = fs::path(testing::TempDir()) / "copy.yaml";
  write_target(file, read_target(written(kCharucoYaml)));
  EXPECT_EQ(read_target(file), read_target(written(kCharucoYaml)));
}

// Files of newer versions of Kalibr.
TEST(TargetFile, TheFirstTagMayHaveAnotherNumber) {
  const Target target = read_target(written(kAprilGridYaml + "codeOffset: 40\n"));
  EXPECT_EQ(target.code_offset, 40);
  EXPECT_EQ(read_target(written(target_yaml(target))), target);
  const Target larger = read_target(written(changed(kAprilGridYaml, "tagRows: 6", "tagRows: 7")));
  EXPECT_EQ(printed_tags(target)[1].code, printed_tags(larger)[41].code);
  expect_error(kAprilGridYaml + "codeOffset: -1\n", {"'codeOffset'", "-1", "whole number"});
  expect_error(kAprilGridYaml + "codeOffset: 552\n", {"number 587", "at most 586"});
}

TEST(TargetFile, ErrorsSayWhatWasExpected) {
  expect_error("target_type: circlegrid\ntargetCols: 6\n",
               {"circlegrid", "'aprilgrid'", "not read"});
  expect_error("target_type: april\n", {":1:", "'april'", "'charuco'"});
  expect_error("tagCols: 6\n", {"target_type", "missing"});
  expect_error(changed(kAprilGridYaml, "tagRows: 6", ""), {"'tagRows' is missing"});
  expect_error(changed(kAprilGridYaml, "tagRows: 6", "tagRows: 6.5"),
               {":3:", "6.5", "whole number"});
  expect_error(changed(kAprilGridYaml, "tagRows: 6", "tagRows: 0"), {"'tagRows'", "above 0"});
  expect_error(changed(kAprilGridYaml, "tagRows: 6", "tagRows: 99"),
               {"6 x 99", "number 593", "at most 586"});
  expect_error(changed(kAprilGridYaml, "0.088", "88"), {"found 88", "millimetres"});
  expect_error(changed(kAprilGridYaml, "0.088", "-0.088"), {"'tagSize'", "positive"});
  expect_error(changed(kAprilGridYaml, "0.3", "0.0264"), {"'tagSpacing'", "0.0264 m, write 0.3"});
  expect_error(changed(kAprilGridYaml, "0.3", "26.4"), {"26.4", "0.05 to 2"});
  expect_error(kAprilGridYaml + "tagBorder: 1\n", {"tagBorder", "unknown"});
  expect_error(changed(kCheckerboardYaml, "targetCols: 6", "targetCols: 2"),
               {"found 2", "inner corners"});
  expect_error(changed(kCheckerboardYaml, "0.06", "nan"), {"'rowSpacingMeters'"});
  expect_error(changed(kCharucoYaml, "5X5_100", "5X5_101"), {"DICT_5X5_101", "did you mean"});
  expect_error(changed(kCharucoYaml, "5X5_100", "4X4_50") + "x: 1", {"'x'", "unknown"});
  expect_error(changed(kCharucoYaml, "0.03", "0.04"), {"0.04", "0.95"});
  expect_error(changed(kCharucoYaml, "squaresX: 5", "squaresX: 60"), {"number 239", "at most 99"});
  expect_error(changed(kCharucoYaml, "legacy_pattern: true", "legacy_pattern: 1"),
               {"true", "false"});
  expect_error(changed(kCharucoYaml, "legacy_pattern: true\n", ""),
               {"'legacy_pattern' is missing"});
}

TEST(TargetCorners, AprilGridAsInEuRoC) {
  const auto corners = read_target(written(kAprilGridYaml)).corners();
  ASSERT_EQ(corners.size(), 144u);
  // The first corners of tags 0, 1 and 6, of ../shared/data/euroc/imu_april/landmarks.csv.
  EXPECT_TRUE(corners[0].isZero());
  EXPECT_TRUE(corners[1].isApprox(Eigen::Vector3d(0.088, 0, 0)));
  EXPECT_TRUE(corners[2].isApprox(Eigen::Vector3d(0.088, 0.088, 0)));
  EXPECT_TRUE(corners[3].isApprox(Eigen::Vector3d(0, 0.088, 0)));
  EXPECT_TRUE(corners[4].isApprox(Eigen::Vector3d(0.1144, 0, 0)));
  EXPECT_TRUE(corners[26].isApprox(Eigen::Vector3d(0.088, 0.2024, 0)));
}

TEST(TargetCorners, CheckerboardsGoUpAndCharucoDown) {
  const auto board = read_target(written(kCheckerboardYaml)).corners();
  ASSERT_EQ(board.size(), 42u);
  EXPECT_TRUE(board[7].isApprox(Eigen::Vector3d(0.05, 0.06, 0)));
  const auto charuco = read_target(written(kCharucoYaml)).corners();
  ASSERT_EQ(charuco.size(), 28u);
  EXPECT_TRUE(charuco[0].isApprox(Eigen::Vector3d(0, 0.24, 0)));
  EXPECT_TRUE(charuco[24].isZero());
}

TEST(TargetCorners, HalfATurn) {
  EXPECT_FALSE(read_target(written(kCheckerboardYaml)).is_symmetric());
  EXPECT_TRUE(read_target(written(changed(kCheckerboardYaml, "6", "5"))).is_symmetric());
  EXPECT_FALSE(read_target(written(kAprilGridYaml)).is_symmetric());
}

TEST(TargetCodes, FourQuartersOfATurn) {
  const std::uint64_t code = marker_dictionary("DICT_6X6_50").codes[7];
  std::uint64_t again = code;
  for (int k = 0; k < 4; ++k) {
    again = turned(again, 6);
    EXPECT_EQ(again == code, k == 3);
  }
  EXPECT_EQ(turned(0b100000000, 3), 0b000000100u) << "upper left to lower left";
}

// The first code of the family 36h11 (Olson), row by row from the upper left.
TEST(TargetCodes, AprilTagsAreUpright) {
  const auto tags = printed_tags(read_target(written(kAprilGridYaml)));
  EXPECT_EQ(tags[0].code, 0xd5d628584u);
}

// The distances are those of the dictionaries' names or of OpenCV's corrections.
TEST(TargetCodes, MarkersDifferInAnyTurn) {
  const std::vector<std::pair<std::string, int>> least = {
      {"DICT_APRILTAG_36h11", 11}, {"DICT_APRILTAG_25h9", 9}, {"DICT_APRILTAG_16h5", 5},
      {"DICT_4X4_50", 4},          {"DICT_5X5_50", 7},        {"DICT_ARUCO_MIP_36h12", 12}};
  for (const auto& [name, distance] : least) {
    const MarkerDictionary dictionary = marker_dictionary(name);
    for (std::size_t i = 0; i < dictionary.codes.size(); ++i) {
      std::uint64_t code = dictionary.codes[i];
      for (int turn = 0; turn < 4; ++turn, code = turned(code, dictionary.side)) {
        for (std::size_t j = i + (turn == 0 ? 1 : 0); j < dictionary.codes.size(); ++j) {
          ASSERT_GE(std::popcount(code ^ dictionary.codes[j]), distance) << name << i << ' ' << j;
        }
      }
    }
  }
}

}  // namespace
}  // namespace chasles
