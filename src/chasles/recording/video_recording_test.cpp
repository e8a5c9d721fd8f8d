#include <chasles/recording/image_testing.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/video_files.hpp>
#include <chasles/video/gpmf_testing.hpp>
#include <chasles/video/picture_testing.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;
using test::VideoForm;
using test::VideoWriter;

std::string calibration_of(int width, int height) {
  return fmt::format(
      "format: chasles-recording-1\nname: any\ncameras:\n  - resolution: [{}, {}]\n"
      "    intrinsics: [40, 40, 31.5, 23.5]\n    distortion_model: none\n    cam_T_imu:\n"
      "      - [1, 0, 0, 0]\n      - [0, 1, 0, 0]\n      - [0, 0, 1, 0]\n"
      "      - [0, 0, 0, 1]\nimu_convention: instant\n",
      width, height);
}

// From `first` on, at 200 Hz for 1.2 s.
std::string samples_from(double first) {
  std::string rows = "time_ns,wx,wy,wz,ax,ay,az\n";
  for (int k = 0; k < 240; ++k) {
    rows += fmt::format("{},0.1,0.2,0.3,1,2,9.5\n",
                        static_cast<std::int64_t>(first * 1e9) + k * 5'000'000);
  }
  return rows;
}

class VideoRecording : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = test::scratch() / "demo_7";
    fs::create_directories(folder);
    write_video("walk.mp4");
    test::spill(folder / "calibration.yaml", calibration_of(64, 48));
    test::spill(folder / "imu.csv", samples_from(-0.1));
  }
  void write_video(const std::string& name, const VideoForm& form = {.options = "qp=0"}) const {
    VideoWriter::write(folder / name, pictures, form);
  }
  std::string error(const std::string& name = "walk.mp4") const {
    return input_error([&] { read_recording(folder / name); });
  }
  static std::string remarks_of(const Recording& recording) {
    std::string all;
    for (const std::string& remark : recording.remarks) all += remark + "\n";
    return all;
  }
  void spill_mask(const std::string& name, int left, int right) const {
    cv::Mat mask(48, 64, CV_8UC1, cv::Scalar(right));
    mask.colRange(0, 16).setTo(left);
    test::spill(folder / name, test::encoded(mask));
  }

  const std::vector<ImageFrame> pictures = test::moving_pictures(20);
  fs::path folder;
};

TEST_F(VideoRecording, PicturesAndSamplesAreReadAtTheirTimes) {
  for (const fs::path& path : {folder / "walk.mp4", folder}) {
    const Recording r = read_recording(path);
    EXPECT_EQ(r.name, path == folder ? "demo_7" : "walk");
    EXPECT_EQ(r.imu.size(), 240u);
    ASSERT_EQ(r.images->size(), pictures.size());
    for (const std::size_t i : {std::size_t{0}, std::size_t{7}, std::size_t{19}}) {
      EXPECT_EQ(r.images->time(i), pictures[i].time);
      EXPECT_EQ(r.images->read(i).images[0].pixels, pictures[i].images[0].pixels) << i;
    }
    EXPECT_TRUE(r.masks.empty());
    EXPECT_TRUE(r.remarks.empty()) << remarks_of(r);
  }
}

TEST_F(VideoRecording, ATimeOffsetOfTheCalibrationIsAdded) {
  std::string calibration = calibration_of(64, 48);
  calibration.insert(calibration.find("    cam_T_imu"), "    timeshift_cam_imu: 0.02\n");
  test::spill(folder / "walk.yaml", calibration);  // comes before calibration.yaml
  const Recording r = read_recording(folder / "walk.mp4");
  EXPECT_EQ(r.images->time(3), pictures[3].time + std::chrono::milliseconds(20));
}

// Sample and calibration of one among several videos have its name.
TEST_F(VideoRecording, AmongSeveralVideosTheOwnFilesCount) {
  write_video("run.mp4");
  expect_parts(error(), {"walk.mp4: has no samples of an IMU", "walk_imu.csv"});
  expect_parts(error(""), {"demo_7/: has 2 videos (run.mp4, walk.mp4), expected one"});
  test::spill(folder / "walk_imu.csv", samples_from(-0.2));
  EXPECT_EQ(read_recording(folder / "walk.mp4").imu.front().time, std::chrono::milliseconds(-200));
}

TEST_F(VideoRecording, TheCalibrationOfManyIsAboveTheirFolders) {
  fs::rename(folder / "calibration.yaml", folder.parent_path() / "calibration.yaml");
  expect_parts(remarks_of(read_recording(folder)), {"that of the folder above it is taken"});
  expect_parts(remarks_of(read_recording(folder / "")), {"that of the folder above it is taken"});
  expect_parts(error(), {"walk.mp4: there is no calibration", "walk.yaml", "camchain-imucam.yaml"});
}

TEST_F(VideoRecording, AnotherSizeThanThatOfTheCalibrationIsAnErrorWithWhatToDo) {
  test::spill(folder / "calibration.yaml", calibration_of(32, 24));
  expect_parts(error(), {"64 x 48 pixels, expected 32 x 24", "2 times as large", "fx and fy by 2"});
  test::spill(folder / "calibration.yaml", calibration_of(64, 36));
  expect_parts(error(), {"64 x 48 pixels, expected 64 x 36", "field of view"});
}

TEST_F(VideoRecording, AListOfTimesBesideItCounts) {
  std::string list;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    list += fmt::format("{}\n", 5'000'000'000'000 + static_cast<std::int64_t>(i) * 40'000'000);
  }
  test::spill(folder / "imu.csv", samples_from(5000));
  test::spill(folder / "frame_timestamps.txt", list);
  const Recording r = read_recording(folder);
  EXPECT_EQ(r.images->time(2), std::chrono::milliseconds(5'000'080));
  expect_parts(remarks_of(r), {"the times of the pictures are those of frame_timestamps.txt"});
  test::spill(folder / "frame_timestamps.txt", list.substr(0, list.size() - 14));
  expect_parts(error(), {"frame_timestamps.txt: has 19 times, expected 20"});
  fs::remove(folder / "frame_timestamps.txt");
  expect_parts(error(), {"walk.mp4"});  // two clocks
}

TEST_F(VideoRecording, MasksAreFoundByNameAndUmisIsInverted) {
  spill_mask("mask.png", 0, 255);
  Recording r = read_recording(folder);
  ASSERT_EQ(r.masks.size(), 1u);
  EXPECT_EQ(r.masks[0].pixels[15], 0);
  EXPECT_EQ(r.masks[0].pixels[16], 255);
  expect_parts(remarks_of(r), {"mask.png hides 25.0 % of the pictures, where it is black"});
  fs::remove(folder / "mask.png");
  spill_mask("slam_mask.png", 255, 0);
  r = read_recording(folder);
  EXPECT_EQ(r.masks[0].pixels[15], 0);
  EXPECT_EQ(r.masks[0].pixels[16], 255);
  expect_parts(remarks_of(r),
               {"slam_mask.png hides 25.0 % of the pictures, where it is not black"});
  spill_mask("slam_mask.png", 255, 255);
  expect_parts(error(), {"slam_mask.png: all pixels of this mask are white", "is it inverted?"});
}

// One device of gopro-telemetry: values are z, x, y; the gyroscope begins 30 ms after the
// accelerometer. `cts` are by a clock in which the video begins at 85.6 ms, and the accelerometer
// 5 ms before; it runs 1.001 times as fast as that of the pictures.
std::string gopro_json(const std::string& units = "m/s2", const std::string& of_pictures = "CORI",
                       const std::vector<ImageFrame>& pictures = {}) {
  const auto cts = [](double seconds) { return 85.6 + 1001.0 * seconds; };
  const auto stream = [&](double first, double period, const std::string& about) {
    std::string samples;
    for (int i = 0; i * period < 1.0; ++i) {
      samples +=
          fmt::format(R"({}{{"value":[9.5,1,2],"cts":{},"date":"2024-01-01T00:00:00.000Z"}})",
                      i > 0 ? "," : "", cts(first + i * period));
    }
    return fmt::format(R"({{"samples":[{}],{}}})", samples, about);
  };
  std::string shown;
  for (const ImageFrame& picture : pictures) {
    shown += fmt::format(R"({}{{"value":[1,0,0,0],"cts":{}}})", shown.empty() ? "" : ",",
                         cts(to_seconds(picture.time)));
  }
  return fmt::format(
      R"({{"1":{{"streams":{{"ACCL":{},"GYRO":{},"{}":{{"samples":[{}]}}}},"device name":"Hero9"}},"frames/second":30}})",
      stream(-0.005, 0.005, fmt::format(R"("name":"Accelerometer","units":"{}")", units)),
      stream(0.025, 0.005, R"~("name":"Gyroscope (z,x,y)","units":"rad/s")~"), of_pictures, shown);
}

TEST_F(VideoRecording, TheJsonOfGoproTelemetryIsReadByTheClockOfThePictures) {
  fs::remove(folder / "imu.csv");
  for (const char* units : {"m/s2", "m/s\xc2\xb2"}) {
    test::spill(folder / "imu_data.json", gopro_json(units, "CORI", pictures));
    const Recording r = read_recording(folder);
    EXPECT_NEAR(to_seconds(r.imu.front().time), 0.025, 2e-6);
    EXPECT_NEAR(to_seconds(r.imu[100].time), 0.525, 2e-6);
    EXPECT_EQ(r.imu.front().specific_force_imu, Eigen::Vector3d(1, 2, 9.5));
    EXPECT_EQ(r.imu.front().angular_rate_imu, Eigen::Vector3d(1, 2, 9.5));
    expect_parts(remarks_of(r), {"those of imu_data.json, by the clock of the pictures' CORI"});
  }
  fs::rename(folder / "imu_data.json", folder / "walk.json");
  EXPECT_NEAR(static_cast<double>(read_recording(folder / "walk.mp4").imu.size()), 195, 2);
}

// The accelerometer then begins at the first picture.
TEST_F(VideoRecording, JsonWithoutAStreamOfPicturesBeginsWithThem) {
  fs::remove(folder / "imu.csv");
  test::spill(folder / "imu_data.json", gopro_json("m/s2", "MAGN", pictures));
  const Recording r = read_recording(folder);
  EXPECT_NEAR(to_seconds(r.imu.front().time), 1.001 * 0.030, 2e-6);
  expect_parts(remarks_of(r), {"the first one at the first picture"});
}

TEST_F(VideoRecording, OddJsonIsAnErrorWithItsPlace) {
  fs::remove(folder / "imu.csv");
  const auto rejected = [&](const std::string& json) {
    test::spill(folder / "imu_data.json", json);
    return error();
  };
  const auto changed = [](const std::string& from, const std::string& to) {
    std::string json = gopro_json();
    return json.replace(json.find(from), from.size(), to);
  };
  expect_parts(rejected(changed("[9.5,1,2]", "[9.5,1]")),
               {"imu_data.json: 1.streams.ACCL.samples[0].value: has 2 numbers, expected three"});
  expect_parts(rejected(changed("[9.5,1,2]", "[9.5,\"1\",2]")),
               {"samples[0].value[1]: found '\"1\"', expected a finite number"});
  expect_parts(rejected(changed("\"cts\":", "\"cts\":null,\"c\":")),
               {"samples[0] 'cts' is missing"});
  expect_parts(rejected(changed("\"cts\":", "\"cts\":1e300,\"c\":")), {"samples[0].cts: found"});
  expect_parts(rejected(changed("GYRO", "GYRA")), {"streams 'GYRO' is missing"});
  expect_parts(rejected(changed("m/s2", "V")), {"ACCL.units: found 'V', expected m/s2 or g"});
  expect_parts(rejected(changed("{\"1\"", "{\"A\"")), {"has no device '1'"});
  expect_parts(rejected("{\"1\":{\"streams\":{\"ACCL\":{\"samples\":7},\"GYRO\":{}}}}"),
               {"ACCL.samples: expected a list"});
  expect_parts(rejected("{\"streams\""), {"imu_data.json"});
  expect_parts(rejected("[1]"), {"imu_data.json"});
}

TEST_F(VideoRecording, TheTelemetryInTheVideoIsReadUnlessATableIsBesideIt) {
  std::vector<test::TimedBytes> telemetry;
  for (int k = 0; k < 2; ++k) {
    std::string items = test::klv_count("DVID", 1) + test::klv_text("DVNM", "Hero5 Black");
    for (const char* key : {"ACCL", "GYRO"}) {
      const std::vector<std::vector<int>> rows(200, {950, 100, 200});
      items +=
          test::nest("STRM", test::klv_count("TSMP", 200u * static_cast<unsigned>(k + 1)) +
                                 test::klv_shorts("SCAL", {{100}}) + test::klv_shorts(key, rows));
    }
    telemetry.push_back({.time = std::chrono::seconds(k),
                         .duration = std::chrono::seconds(1),
                         .bytes = test::nest("DEVC", items)});
  }
  VideoWriter::write(folder / "walk.mp4", pictures, {}, telemetry);
  expect_parts(remarks_of(read_recording(folder)), {"telemetry of its own, which is not read"});
  fs::remove(folder / "imu.csv");
  const Recording r = read_recording(folder);
  EXPECT_EQ(r.imu.size(), 400u);
  EXPECT_EQ(r.imu[0].specific_force_imu, Eigen::Vector3d(1, 2, 9.5));
  EXPECT_NEAR(to_seconds(r.imu[300].time), 1.5, 1e-6);
  expect_parts(remarks_of(r), {"the video's telemetry (1 Hero5 Black)", "in the order Z, X, Y"});
}

TEST_F(VideoRecording, TheNextChapterIsNamed) {
  fs::rename(folder / "walk.mp4", folder / "GX010007.MP4");
  write_video("GX020007.MP4");
  test::spill(folder / "GX010007_imu.csv", samples_from(-0.1));
  expect_parts(remarks_of(read_recording(folder / "GX010007.MP4")),
               {"goes on in GX020007.MP4, which is not read"});
  EXPECT_EQ(next_chapter(folder / "GX020007.MP4"), std::nullopt);
}

TEST_F(VideoRecording, AProjectsOwnFolderIsNoVideo) {
  test::spill(folder / "frames.csv", "time_ns\n");
  EXPECT_FALSE(is_video_folder(folder));
}

}  // namespace
}  // namespace chasles
