#include "cli_test.hpp"

// Folders of recordings as people have them.
namespace chasles::test {
namespace {

namespace fs = std::filesystem;

// A walk of three seconds in small images.
void simulate_images(const Scratch& folder, const std::string& more = "") {
  const Outcome made =
      chasles(folder,
              "simulate walk --images --quiet -o rec --set walk_duration=3 --set rest_duration=1 "
              "--set image_width=320 --set image_height=240 --set focal_length=200 --set "
              "center_u=159.5 --set center_v=119.5 --set texel_size=0.03 --set frame_rate=10 " +
                  more);
  ASSERT_EQ(made.code, 0) << made.err;
}

// Adds 30 ms to the stamps of the images.
void delay_stamps(const fs::path& table) {
  std::istringstream lines(slurp(table));
  std::string line, text;
  std::getline(lines, text);
  text += "\n";
  while (std::getline(lines, line)) {
    const std::size_t comma = line.find(',');
    text +=
        std::to_string(std::stoll(line.substr(0, comma)) + 30'000'000) + line.substr(comma) + "\n";
  }
  spill(table, text);
}

// The frames then have the same times to the nanosecond.
TEST(Folders, AStatedTimeOffsetGivesTheBytesOfACameraWithoutOne) {
  const Scratch folder;
  simulate_images(folder);
  ASSERT_EQ(chasles(folder, "run rec --quiet -o intact").code, 0);
  const fs::path camera = folder / "rec/mav0/cam0";
  delay_stamps(camera / "data.csv");
  ASSERT_EQ(chasles(folder, "run rec --quiet -o late").code, 0);
  spill(camera / "sensor.yaml", slurp(camera / "sensor.yaml") + "timeshift_cam_imu: -0.03\n");
  const Outcome outcome = chasles(folder, "run rec -o corrected");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  expect_part(outcome.out, "cam0 are 30.000 ms late");
  const std::string intact = slurp(folder / "intact/trajectory.tum");
  EXPECT_EQ(slurp(folder / "corrected/trajectory.tum"), intact);
  EXPECT_NE(slurp(folder / "late/trajectory.tum"), intact);
}

TEST(Folders, TheSecondCamerasImagesMayBeMissingIfTheFirstIsAskedFor) {
  const Scratch folder;
  simulate_images(folder, "--set cameras=2 ");
  ASSERT_EQ(chasles(folder, "run rec --quiet --cameras mono -o intact").code, 0);
  fs::remove_all(folder / "rec/mav0/cam1/data");
  fs::remove(folder / "rec/mav0/cam1/data.csv");
  spill(folder / "rec/mav0/cam1/sensor.yaml", "no calibration");
  const Outcome mono = chasles(folder, "run rec --quiet --cameras mono -o alone");
  ASSERT_EQ(mono.code, 0) << mono.err;
  EXPECT_EQ(slurp(folder / "alone/trajectory.tum"), slurp(folder / "intact/trajectory.tum"));
}

// The remark has the cause, and the error stays the last line.
TEST(Folders, TheReadersRemarksComeWithAnErrorAlsoIfQuiet) {
  const Scratch folder;
  simulate_images(folder, "--set cameras=2 ");
  fs::remove_all(folder / "rec/mav0/cam1/data");
  fs::remove(folder / "rec/mav0/cam1/data.csv");
  const Outcome stereo = chasles(folder, "run rec --quiet --cameras stereo");
  expect_error(stereo, 1, "--cameras: camera 1 of rec has no images, expected some of 0");
  expect_part(stereo.err, "chasles: remark: cam1 is calibrated, but has no images: left out\n");
}

TEST(Folders, ImagesThatCannotBeReadEndTheRunAfterAFew) {
  const Scratch folder;
  simulate_images(folder);
  for (const auto& image : fs::directory_iterator(folder / "rec/mav0/cam0/data")) {
    spill(image.path(), slurp(image.path()).substr(0, 300));
  }
  expect_error(chasles(folder, "run rec --quiet -o out"), 2, "none of the first 20 of ");
  expect_error(chasles(folder, "run rec --stop 1.35 --quiet"), 2,
               "frames of images can be read; the first: ");
  const Outcome check = chasles(folder, "check rec");
  EXPECT_EQ(check.code, 2);
  expect_part(check.out,
              "60 of the 60 frames examined have an image that cannot be read; the first: ");
  expect_part(check.out, "the PNG file is truncated");
}

TEST(Folders, AnOutputDoesNotGoAmongTheRecordingsFiles) {
  const Scratch folder;
  simulate_images(folder);
  fs::create_directory_symlink(folder / "rec", folder / "link");
  for (const char* output : {"rec", "rec/", "./rec/../rec", "link", "rec/mav0", "rec/mav0/cam0"}) {
    expect_error(chasles(folder, std::string("run rec --quiet -o ") + output), 1,
                 "whose files an output may overwrite");
  }
  expect_error(chasles(folder, "run rec/mav0 --quiet -o rec"), 1, "the folder of the recording");
  EXPECT_FALSE(fs::exists(folder / "rec/summary.json"));
  EXPECT_FALSE(fs::exists(folder / "rec/mav0/summary.json"));
  // A folder of its own within the recording is none of the recording's.
  for (int k = 0; k < 2; ++k) {
    EXPECT_EQ(chasles(folder, "run rec --quiet --stop 1.5 -o rec/run").code, 0) << k;
  }
  expect_error(chasles(folder, "simulate walk --cameras rec --quiet -o rec"), 1, "choose another");
}

}  // namespace
}  // namespace chasles::test
