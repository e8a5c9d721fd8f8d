#include <chasles/target/target_file.hpp>

#include "cli_test.hpp"

// `chasles calibrate target`: boards to print.
namespace chasles::test {
namespace {

TEST(CalibrateTarget, WritesABoardAndItsFile) {
  const Scratch folder;
  const Outcome outcome = chasles(folder, "calibrate target --size 0.088 -o new/board.pdf");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("new/board.pdf: 737 x 753 mm. Print"), std::string::npos)
      << outcome.out;
  EXPECT_TRUE(slurp(folder / "new/board.pdf").starts_with("%PDF-1.4\n"));
  EXPECT_EQ(read_target(folder / "new/board.yaml"), (Target{.kind = TargetKind::april_grid,
                                                            .columns = 6,
                                                            .rows = 6,
                                                            .tag_size = 0.088,
                                                            .tag_spacing = 0.3}));
}

TEST(CalibrateTarget, EveryKindHasItsNumbers) {
  const Scratch folder;
  ASSERT_EQ(chasles(folder,
                    "calibrate target --kind charuco --columns 5 --rows 8 --size 0.03 "
                    "--dictionary DICT_4X4_50 --legacy-pattern --paper A3 -o a.SVG")
                .code,
            0);
  const Target charuco = read_target(folder / "a.yaml");
  EXPECT_EQ(charuco.tag_size, 0.75 * 0.03);
  EXPECT_EQ(charuco.dictionary, "DICT_4X4_50");
  EXPECT_TRUE(charuco.legacy_pattern);
  EXPECT_NE(slurp(folder / "a.SVG").find("<svg"), std::string::npos);
  const Outcome board =
      chasles(folder, "calibrate target --kind checkerboard --rows 8 --size 0.02 -o b.pdf");
  ASSERT_EQ(board.code, 0) << board.err;
  EXPECT_NE(board.out.find("no upper side"), std::string::npos);
  EXPECT_EQ(read_target(folder / "b.yaml").row_spacing, 0.02);
}

TEST(CalibrateTarget, AMeasuredFileIsNotReplaced) {
  const Scratch folder;
  const std::string command = "calibrate target --size 0.03 -o board.pdf";
  ASSERT_EQ(chasles(folder, command).code, 0);
  ASSERT_EQ(chasles(folder, command).code, 0) << "the same again";
  Target measured = read_target(folder / "board.yaml");
  measured.tag_size = 0.0302;
  write_target(folder / "board.yaml", measured);
  expect_error(chasles(folder, command), 1, "board.yaml: is there with other numbers");
  EXPECT_EQ(read_target(folder / "board.yaml"), measured);
}

TEST(CalibrateTarget, MisuseIsNamed) {
  const Scratch folder;
  const auto error = [&](const std::string& options, const std::string& part) {
    expect_error(chasles(folder, "calibrate target " + options), 1, part);
    EXPECT_FALSE(std::filesystem::exists(folder / "b.yaml"));
  };
  error("-o b.pdf", "--size is required");
  error("--size 0.1", "--output is required");
  error("--size nan -o b.pdf", "--size: found 'nan'");
  error("--size 88 -o b.pdf", "tag_size: found 88, expected metres");
  error("--size 0.1 -o b.png", "found the ending '.png', expected .pdf or .svg");
  error("--size 0.1 --kind april -o b.pdf", "--kind: found 'april', expected one of aprilgrid");
  error("--size 0.1 --marker 0.05 -o b.pdf", "--marker is for --kind charuco");
  error("--size 0.1 --kind charuco --spacing 0.3 -o b.pdf", "--spacing is for --kind aprilgrid");
  error("--size 0.1 --kind charuco --dictionary DICT_5X5_5 -o b.pdf", "did you mean");
  error("--size 0.1 --paper A4 -o b.pdf", "take one of A0");
  error("--size 0.1 --columns 0 -o b.pdf", "columns: found 0");
}

}  // namespace
}  // namespace chasles::test
