#include <chasles/camera/camera_testing.hpp>
#include <chasles/recording/inertial_testing.hpp>
#include <chasles/recording/readers.hpp>

namespace chasles {
namespace {

using test::expect_parts;
using test::inertial;
using test::input_error;

class InertialFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = test::scratch() / "walk";
    write_folder_recording(recording, folder);
  }
  // Replaces the first occurrence in a file of the folder and returns the reader's error message.
  std::string error(const std::string& file, const std::string& from, const std::string& to) {
    write_folder_recording(recording, folder);
    std::string text = test::slurp(folder / file);
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    test::spill(folder / file, text.replace(at, from.size(), to));
    return input_error([&] { read_folder_recording(folder); });
  }

  Recording recording = inertial();
  std::filesystem::path folder;
};

TEST_F(InertialFolder, TheImuIsReadAgainToTheLastBit) {
  const Recording r = read_folder_recording(folder);
  EXPECT_EQ(r.imu_convention, ImuConvention::kIntervalMean);
  ASSERT_TRUE(r.imu_noise);
  EXPECT_EQ(r.imu_noise->accelerometer_noise_density, 2e-3);
  EXPECT_EQ(r.imu_noise->accelerometer_random_walk, 3e-3);
  EXPECT_EQ(r.imu_noise->gyroscope_noise_density, 1.0 / 3 * 1e-4);
  EXPECT_EQ(r.imu_noise->gyroscope_random_walk, 0);
  ASSERT_EQ(r.imu.size(), recording.imu.size());
  for (std::size_t k = 0; k < r.imu.size(); ++k) {
    EXPECT_EQ(r.imu[k].time, recording.imu[k].time);
    EXPECT_EQ(r.imu[k].specific_force_imu, recording.imu[k].specific_force_imu);
    EXPECT_EQ(r.imu[k].angular_rate_imu, recording.imu[k].angular_rate_imu);
  }
  EXPECT_TRUE(r.velocities.empty());
  EXPECT_FALSE(std::filesystem::exists(folder / "velocities.csv"));
}

TEST_F(InertialFolder, TheCamerasAndPixelsAreReadAgainToTheLastBit) {
  const Recording r = read_folder_recording(folder);
  ASSERT_EQ(r.cameras.size(), 2u);
  for (std::size_t c = 0; c < 2; ++c) {
    const Camera &a = r.cameras[c], &b = recording.cameras[c];
    EXPECT_EQ(std::tie(a.width, a.height, a.fx, a.fy, a.cx, a.cy, a.distortion),
              std::tie(b.width, b.height, b.fx, b.fy, b.cx, b.cy, b.distortion));
    EXPECT_EQ(a.coefficients, b.coefficients);
    EXPECT_EQ(a.cam_T_imu.R, b.cam_T_imu.R);
    EXPECT_EQ(a.cam_T_imu.p, b.cam_T_imu.p);
  }
  EXPECT_EQ(r.single_pixel_sigma, recording.single_pixel_sigma);
  EXPECT_EQ(r.rig.fx, 0);
  ASSERT_EQ(r.frames.size(), recording.frames.size());
  for (std::size_t k = 0; k < r.frames.size(); ++k) {
    EXPECT_EQ(r.frames[k].time, recording.frames[k].time);
    EXPECT_TRUE(r.frames[k].observations.empty());
    ASSERT_EQ(r.frames[k].pixels.size(), recording.frames[k].pixels.size());
    for (std::size_t i = 0; i < r.frames[k].pixels.size(); ++i) {
      const auto &a = r.frames[k].pixels[i], &b = recording.frames[k].pixels[i];
      EXPECT_EQ(std::tie(a.landmark, a.camera), std::tie(b.landmark, b.camera));
      EXPECT_EQ(a.pixel, b.pixel);
    }
  }
}

TEST_F(InertialFolder, WhichPixelsAreMatchesIsReadAgainIfItIsKnown) {
  for (const FeatureFrame& frame : read_folder_recording(folder).frames) {
    for (const PixelObservation& o : frame.pixels) EXPECT_FALSE(o.match.has_value());
  }
  for (FeatureFrame& frame : recording.frames) {
    for (PixelObservation& o : frame.pixels) o.match = o.camera == 0;
  }
  write_folder_recording(recording, folder);
  int pixels = 0;
  for (const FeatureFrame& frame : read_folder_recording(folder).frames) {
    for (const PixelObservation& o : frame.pixels) {
      EXPECT_EQ(o.match, o.camera == 0);
      ++pixels;
    }
  }
  EXPECT_GT(pixels, 0);
  std::string text = test::slurp(folder / "pixels.csv");
  text[text.rfind(',') + 1] = '2';
  test::spill(folder / "pixels.csv", text);
  expect_parts(input_error([&] { read_folder_recording(folder); }),
               {"pixels.csv", "match", "found 2", "expected 0", "or 1"});
}

TEST_F(InertialFolder, EachLensIsReadAgainToTheLastBit) {
  for (const test::Lens& lens : test::lenses()) {
    recording.cameras[0].distortion = lens.camera.distortion;
    recording.cameras[0].coefficients = lens.camera.coefficients;
    write_folder_recording(recording, folder);
    const Recording r = read_folder_recording(folder);
    EXPECT_EQ(r.cameras[0].distortion, lens.camera.distortion);
    EXPECT_EQ(r.cameras[0].coefficients, lens.camera.coefficients);
  }
}

// The frames of tracks have one table of times for all cameras.
TEST_F(InertialFolder, ATimeOffsetIsForImages) {
  expect_parts(
      error("calibration.yaml", "    cam_T_imu:", "    timeshift_cam_imu: 0.01\n    cam_T_imu:"),
      {"calibration.yaml", "timeshift_cam_imu", "0.01 s", "frames.csv"});
}

TEST_F(InertialFolder, TheTruthIsReadAgainToTheLastBit) {
  const Recording r = read_folder_recording(folder);
  ASSERT_EQ(r.truth.size(), recording.truth.size());
  ASSERT_EQ(r.true_motion.size(), recording.true_motion.size());
  for (std::size_t k = 0; k < r.truth.size(); ++k) {
    const TrueMotion &a = r.true_motion[k], &b = recording.true_motion[k];
    EXPECT_EQ(a.time, b.time);
    EXPECT_EQ(a.v_world, b.v_world);
    EXPECT_EQ(a.accelerometer_bias, b.accelerometer_bias);
    EXPECT_EQ(a.gyroscope_bias, b.gyroscope_bias);
    EXPECT_EQ(r.truth[k].pose.p, recording.truth[k].pose.p);
  }
  EXPECT_EQ(r.true_landmarks.size(), 3u);
}

TEST_F(InertialFolder, WhatIsWrittenAgainIsTheSameBytes) {
  const auto again = test::scratch() / "again";
  write_folder_recording(recording, folder);
  write_folder_recording(read_folder_recording(folder), again);
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".tum") continue;  // its quaternions are rounded once
    EXPECT_EQ(test::slurp(entry.path()), test::slurp(again / entry.path().filename()))
        << entry.path();
  }
}

TEST_F(InertialFolder, AnImuAloneIsARecording) {
  recording.cameras.clear();
  recording.frames.clear();
  recording.imu_noise.reset();
  recording.single_pixel_sigma.reset();
  recording.imu_convention = ImuConvention::kInstant;
  write_folder_recording(recording, folder);
  const Recording r = read_recording(folder);
  EXPECT_EQ(r.imu.size(), recording.imu.size());
  EXPECT_EQ(r.imu_convention, ImuConvention::kInstant);
  EXPECT_FALSE(r.imu_noise);
  EXPECT_TRUE(r.cameras.empty());
  EXPECT_TRUE(r.frames.empty());
  EXPECT_FALSE(std::filesystem::exists(folder / "pixels.csv")) << "of the recording before";
}

TEST_F(InertialFolder, ARigAndAnImuGoTogether) {
  const Recording drive = test::drive({.frames = 12, .tracks = 30});
  recording.rig = drive.rig;
  recording.frames[0].observations = drive.frames[0].observations;
  recording.velocities = drive.velocities;
  write_folder_recording(recording, folder);
  const Recording r = read_folder_recording(folder);
  EXPECT_EQ(r.rig.baseline, drive.rig.baseline);
  EXPECT_EQ(r.frames[0].observations.size(), drive.frames[0].observations.size());
  EXPECT_EQ(r.frames[0].pixels.size(), 6u);
  EXPECT_EQ(r.velocities.size(), 12u);
  EXPECT_EQ(r.imu.size(), recording.imu.size());
}

TEST_F(InertialFolder, TheImuTableIsChecked) {
  const std::string file = "imu.csv";
  expect_parts(error(file, "wx,wy", "ax,wy"),
               {"imu.csv:1: has the columns time_ns,ax", "expected"});
  expect_parts(error(file, "\n5000000,", "\n0,"),
               {"imu.csv:3: column 'time_ns': the time 0.000000000", "rise strictly"});
  expect_parts(error(file, "\n10000000,", "\n4000000,"), {"imu.csv:4: column 'time_ns'", "rise"});
  expect_parts(error(file, "\n5000000,", "\n5000000,nan,"),
               {"imu.csv:3: has 8 values, expected 7"});
  recording.imu[1].specific_force_imu.y() = std::nan("");
  write_folder_recording(recording, folder);
  const Recording read = read_folder_recording(folder);
  EXPECT_EQ(read.imu.size(), recording.imu.size() - 1);
  expect_parts(read.remarks.back(), {"1 of", "IMU samples are not finite numbers: left out"});
  std::filesystem::remove(folder / file);
  expect_parts(input_error([&] { read_folder_recording(folder); }), {"imu.csv: no such file"});
}

TEST_F(InertialFolder, ThePixelTableIsChecked) {
  const std::string file = "pixels.csv";
  expect_parts(error(file, "camera,landmark", "landmark,camera"),
               {"pixels.csv:1: has the columns"});
  expect_parts(error(file, "\n25000000,0,0,", "\n25000000,2,0,"),
               {"pixels.csv:2: column 'camera': there is no camera 2, expected 0 to 1"});
  expect_parts(error(file, "\n25000000,0,0,", "\n25000000,-1,0,"), {"there is no camera -1"});
  expect_parts(error(file, "\n25000000,0,1,", "\n25000000,0,0,"),
               {"pixels.csv: landmark 0 is there twice at 25000000 ns", "in camera 0"});
  expect_parts(error(file, "\n25000000,", "\n25000001,"), {"25000001 is no frame of frames.csv"});
  expect_parts(error("frames.csv", "\n25000000,0,6", "\n25000000,0,7"),
               {"pixels.csv: holds 6 observations", "expected 7 as in frames.csv"});
  expect_parts(error("frames.csv", "\n25000000,0,6", "\n25000000,2,6"),
               {"features.csv: holds 0 observations", "expected 2"});
  recording.frames[2].pixels[1].pixel.y() = std::numeric_limits<double>::infinity();
  write_folder_recording(recording, folder);
  expect_parts(input_error([&] { read_folder_recording(folder); }),
               {"pixels.csv:15: column 'v': found 'inf', expected a finite number"});
  std::filesystem::remove(folder / file);
  expect_parts(input_error([&] { read_folder_recording(folder); }), {"pixels.csv: no such file"});
}

TEST_F(InertialFolder, TheTrueMotionIsThatOfTheTruth) {
  const std::string file = "true_motion.csv";
  expect_parts(error(file, "bax,bay", "bay,bax"), {"true_motion.csv:1: has the columns"});
  expect_parts(error(file, "\n75000000,", "\n76000000,"),
               {"true_motion.csv:3: column 'time_ns': is 76000000, expected 75000000"});
  recording.true_motion.pop_back();
  write_folder_recording(recording, folder);
  expect_parts(input_error([&] { read_folder_recording(folder); }),
               {"true_motion.csv: holds 39 rows, expected 40"});
  recording = inertial();
  recording.true_motion.push_back(recording.true_motion.back());
  write_folder_recording(recording, folder);
  expect_parts(input_error([&] { read_folder_recording(folder); }), {"expected no further row"});
  recording = inertial();
  recording.true_motion[0].gyroscope_bias.x() = std::nan("");
  write_folder_recording(recording, folder);
  expect_parts(input_error([&] { read_folder_recording(folder); }),
               {"true_motion.csv:2: column 'bgx': found 'nan'"});
}

TEST_F(InertialFolder, FilesThatTheCalibrationDoesNotKnowAreRejected) {
  expect_parts(error("calibration.yaml", "imu_convention: interval-mean\n", ""),
               {"imu.csv: is there, but calibration.yaml has no imu_convention"});
  test::spill(folder / "velocities.csv", "time_ns,vx,vy,vz,wx,wy,wz\n");
  std::filesystem::remove(folder / "imu.csv");
  test::spill(folder / "features.csv", "time_ns\n");
  expect_parts(input_error([&] { read_folder_recording(folder); }),
               {"features.csv: is there, but calibration.yaml has no rig"});
  recording.cameras.clear();
  for (FeatureFrame& frame : recording.frames) frame.pixels.clear();
  write_folder_recording(recording, folder);
  test::spill(folder / "pixels.csv", "time_ns\n");
  expect_parts(input_error([&] { read_folder_recording(folder); }),
               {"pixels.csv: is there, but calibration.yaml has no cameras"});
}

TEST_F(InertialFolder, TheImuKeysOfTheCalibrationAreChecked) {
  const std::string file = "calibration.yaml";
  expect_parts(
      error(file, "interval-mean\n", "mean\n"),
      {"calibration.yaml:", "'imu_convention': is 'mean', expected one of instant, interval-mean"});
  expect_parts(error(file, "gyroscope_random_walk: 0\n", ""),
               {"calibration.yaml: key 'gyroscope_random_walk' is missing"});
  expect_parts(error(file, "random_walk: 0\n", "random_walk: -1\n"),
               {"'gyroscope_random_walk': is -1, expected a number that is not negative"});
  expect_parts(error(file, "accelerometer_noise_density", "acelerometer_noise_density"),
               {"is unknown", "did you mean 'accelerometer_noise_density'?"});
  expect_parts(error(file, "single_pixel_sigma: ", "single_pixel_sigma: -"),
               {"'single_pixel_sigma': is -0.33", "expected a positive number"});
}

TEST_F(InertialFolder, StatesWhetherTheTruthIsLevel) {
  EXPECT_EQ(read_folder_recording(folder).truth_level, std::nullopt);
  for (const bool level : {true, false}) {
    recording.truth_level = level;
    write_folder_recording(recording, folder);
    EXPECT_EQ(read_folder_recording(folder).truth_level, level);
  }
  expect_parts(error("calibration.yaml", "truth_level: false", "truth_level: 3 deg"),
               {"calibration.yaml:", "key 'truth_level': is '3 deg', expected true", "or false"});
}

TEST_F(InertialFolder, StatesWhetherTheNoiseIsExact) {
  for (const bool exact : {true, false}) {
    recording.imu_noise->exact = exact;
    write_folder_recording(recording, folder);
    EXPECT_EQ(read_folder_recording(folder).imu_noise->exact, exact);
  }
  recording.imu_noise->exact = true;
  write_folder_recording(recording, folder);
  expect_parts(error("calibration.yaml", "noise_is_exact: true", "noise_is_exact: 1"),
               {"calibration.yaml:", "key 'noise_is_exact': is '1', expected true", "or false"});
}

TEST_F(InertialFolder, ARollingShutterIsReadAgain) {
  recording.cameras[1].shutter = {.readout = 0.0206, .direction = ReadoutDirection::kLeft};
  write_folder_recording(recording, folder);
  const Recording r = read_folder_recording(folder);
  EXPECT_FALSE(r.cameras[0].shutter.is_rolling());
  EXPECT_EQ(r.cameras[1].shutter.readout, 0.0206);
  EXPECT_EQ(r.cameras[1].shutter.direction, ReadoutDirection::kLeft);
  const std::string file = "calibration.yaml";
  expect_parts(error(file, "readout_time: 0.0206", "readout_time: 20.6"),
               {"'readout_time': is 20.6", "in seconds, from 0", "to 0.2"});
  expect_parts(error(file, "readout_time: 0.0206", "readout_time: -0.01"), {"is -0.01"});
  expect_parts(error(file, "readout_time: 0.0206", "readout_time: .nan"), {"'readout_time'"});
  expect_parts(error(file, "readout_direction: left", "readout_direction: west"),
               {"'readout_direction': is 'west', expected one of down, up, right, left"});
}

TEST_F(InertialFolder, TheCamerasOfTheCalibrationAreChecked) {
  const std::string file = "calibration.yaml";
  expect_parts(error(file, "equidistant\n", "cubic\n"),
               {"'distortion_model': 'cubic' is a model that is not supported", "none, radtan"});
  expect_parts(error(file, "equidistant\n", "omni\n"),
               {"'distortion_coeffs': has 4 coefficients, expected 1 or 5", "xi [k1 k2 p1 p2]"});
  expect_parts(error(file, "equidistant\n", "none\n"),
               {"'distortion_coeffs': is not zero", "'none'"});
  expect_parts(error(file, "[640, 480]", "[640]"), {":7: key 'resolution': expected a list of 2"});
  expect_parts(error(file, "[640, 480]", "[640.5, 480]"), {"is 640.5, expected a whole number"});
  expect_parts(error(file, "[300.1,", "[-300.1,"), {"'intrinsics': is -300.1", "positive"});
  expect_parts(error(file, "[300.1,", "[.nan,"), {"'intrinsics': found '.nan'"});
  expect_parts(error(file, ", -1e-05]", "]"),
               {"'distortion_coeffs': has 3 coefficients, expected 4"});
  expect_parts(error(file, "[0, 0, 0, 1]", "[0, 0, 0, 2]"),
               {"'cam_T_imu': the last row is (0, 0, 0, 2)"});
  expect_parts(error(file, "      - [0, 0, 0, 1]\n", ""),
               {"'cam_T_imu': expected 4 rows of 4 numbers"});
  expect_parts(error(file, "  - resolution:", "  - size:"), {":7: key 'size': is unknown"});
  expect_parts(error(file, "    distortion_model: equidistant\n", ""),
               {"calibration.yaml:7: key 'distortion_model' is missing"});
  recording.cameras[1].cam_T_imu.R.col(0) *= -1;
  write_folder_recording(recording, folder);
  expect_parts(input_error([&] { read_folder_recording(folder); }),
               {"'cam_T_imu': the 3x3 part is a reflection (determinant -1)"});
  recording.cameras[1].cam_T_imu.R *= 1.1;
  write_folder_recording(recording, folder);
  expect_parts(input_error([&] { read_folder_recording(folder); }), {"is not a rotation"});
}

TEST_F(InertialFolder, ATruncatedFileIsNoticed) {
  for (const char* file : {"imu.csv", "pixels.csv", "true_motion.csv", "frames.csv"}) {
    write_folder_recording(recording, folder);
    const std::string text = test::slurp(folder / file);
    for (std::size_t cut = 1; cut < 60; cut += 7) {
      test::spill(folder / file, text.substr(0, text.size() - cut));
      try {  // a whole number may stay of a longer one
        expect_parts(read_folder_recording(folder).remarks.back(), {file, "may be truncated"});
      } catch (const InputError& error) {
        expect_parts(error.what(), {file});
      }
    }
  }
}

}  // namespace
}  // namespace chasles
