#include <chasles/recording/image_testing.hpp>
#include <chasles/recording/readers.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;

class ForeignKinds : public ::testing::Test {
 protected:
  void SetUp() override { folder = test::scratch() / "given"; }
  void add(const std::string& file, const std::string& bytes = "x") const {
    fs::create_directories((folder / file).parent_path());
    test::spill(folder / file, bytes);
  }
  // The message about the folder or a file in it; the folder is empty again afterwards.
  std::string answer(const std::string& file = "") {
    const std::string message =
        input_error([&] { read_recording(file.empty() ? folder : folder / file); });
    EXPECT_EQ(message.find("ECE276A"), std::string::npos) << "the list of all kinds: " << message;
    fs::remove_all(folder);
    fs::create_directories(folder);
    return message;
  }
  fs::path folder;
};

TEST_F(ForeignKinds, FoldersAreNamedForWhatTheyLookLike) {
  add("MH_01_easy.zip");
  expect_parts(answer(), {"archives (MH_01_easy.zip): unpack"});
  add("walk/walk_0.mcap");
  expect_parts(answer(), {"the folder above a recording: give that one (walk)"});
  for (const char* archive : {"a.zip", "b.zip", "c.tar", "d.7z"}) add(archive);
  expect_parts(answer(), {"archives (a.zip, b.zip, c.tar and 1 more)"});
  add("states.csv");
  add("summary.json");
  add("images/cam0_5.jpg");
  expect_parts(answer(), {"run folder", "give the recording"});
  add("rgb.txt");
  add("depth.txt");
  expect_parts(answer(), {"TUM RGB-D", "no gyroscope"});
  add("rgb.txt");
  add("accelerometer.txt");
  expect_parts(answer(), {"TUM RGB-D", "accelerometer.txt has accelerations alone"});
  add("left_images.txt");
  expect_parts(answer(), {"UZH-FPV without its imu.txt"});
  for (const std::string ending : {".txt", ".bin"}) {
    for (const char* part : {"cameras", "images", "points3D"}) add(part + ending);
    const std::string message = answer();
    expect_parts(message, {"a model of COLMAP (cameras" + ending, "neither times nor an IMU"});
    EXPECT_EQ(message.find("UZH-FPV"), std::string::npos) << message;
  }
  add("left/0.png");
  add("right/0.png");
  expect_parts(answer(),
               {"folders of images (left, right)", "images/cam0", "order of the calibration"});
  add("calib.txt");
  add("times.txt");
  expect_parts(answer(), {"KITTI odometry without its images"});
  add("cam0/5.png");
  expect_parts(answer(), {"extracted bag", "imu.csv"});
  add("_slash_cam0_slash_image_raw.csv");
  expect_parts(answer(), {"extracted bag"});
  add("0001.PNG");
  add("0002.jpg");
  expect_parts(answer(), {"2 images alone", "images/cam0"});
  expect_parts(answer(), {"given: is empty"});
}

TEST_F(ForeignKinds, TheFolderAboveARecordingNamesIt) {
  test::write_euroc_folder(folder / "MH_01_easy" / "MH_01_easy", 1);
  expect_parts(answer(), {"the folder above a recording", "MH_01_easy/MH_01_easy"});
  test::write_euroc_folder(folder / "MH_01_easy", 1);
  test::write_euroc_folder(folder / "V1_01_easy", 1);
  expect_parts(answer(), {"several recordings: give one of them (MH_01_easy, V1_01_easy)"});
  test::write_euroc_folder(folder / "MH_01_easy", 1);
  fs::create_directories(folder / "MH_01_easy/mav0/cam0/data");
  expect_parts(input_error([&] { read_recording(folder / "MH_01_easy/mav0/cam0"); }),
               {"one sensor of an EuRoC recording"});
}

TEST_F(ForeignKinds, FilesAreNamedForWhatTheyLookLike) {
  add("walk.mkv", "\x1a\x45\xdf\xa3");
  expect_parts(answer("walk.mkv"), {"walk.mkv: looks like a video that is no MP4", "ffmpeg -i"});
  add("0.png", test::picture_bytes(3));
  expect_parts(answer("0.png"), {"a single image"});
  add("imu.yaml", "update_rate: 200\n");
  expect_parts(answer("imu.yaml"), {"a calibration", "give the folder"});
  const std::string name = "mav0/cam0/data.csv";
  add("MH_01.zip", std::string("PK\x03\x04", 4) + std::string(22, '\0') +
                       std::string(1, static_cast<char>(name.size())) + std::string(3, '\0') +
                       name);
  expect_parts(answer("MH_01.zip"), {"zip archive of mav0/cam0/data.csv: unzip it"});
  add("MH_01.tar.gz", "\x1f\x8b\x08");
  expect_parts(answer("MH_01.tar.gz"), {"unpack it"});
}

TEST_F(ForeignKinds, LogsAndRecordingsOfOtherProgramsAreNamed) {
  const auto named = [&](const std::string& file, const std::string& bytes,
                         std::initializer_list<std::string> parts) {
    add(file, bytes);
    const std::string message = answer(file);
    expect_parts(message, parts);
    EXPECT_NE(message.find(file + ": "), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << "in one line";
  };
  named("log.ulg", "ULog\x01\x12\x35\x01", {"PX4", "no images", "ulog2csv"});
  named("00000042.BIN", "\xa3\x95\x80\x80\x59", {"ArduPilot", "no images"});
  named("rec.vrs", "VisionRe", {"VRS", "vrs extract-all"});
  named("rec.svo", "SVO", {"ZED camera", "record images and IMU as a bag"});
  named("rec.SVO2", std::string("\x89MCAP0\r\n\0\0", 10), {"ZED camera (SVO2)"});
  named("oak.rrd", "RRF2", {"Rerun"});
  named("imu.parquet", "PAR1", {"Parquet", "to_csv"});
  named("imu.npy", "\x93NUMPY", {"single NumPy array", "savetxt"});
  named("rec.h5", "\x89HDF\r\n\x1a\n", {"HDF5"});
  named("rec.jsonl", "{\"time\": 0}\n", {"JSON", "imu.csv"});
  named("table.xlsx",
        std::string("PK\x03\x04", 4) + std::string(22, '\0') + std::string("\x13\0\0\0", 4) +
            "[Content_Types].xml",
        {"spreadsheet", "CSV"});
  named("walk.tar.zst", "\x28\xb5\x2f\xfd", {"an archive"});
  named("walk", std::string(257, 'x') + "ustar", {"an archive"});
  named("VID.insv",
        std::string("\0\0\0\x20"
                    "ftypisom",
                    12),
        {"Insta360"});
}

// Whatever the name is, such a file is not the one that was meant.
TEST_F(ForeignKinds, WhatStandsInThePlaceOfAFileIsNamed) {
  for (const char* name : {"walk.bag", "walk.mcap", "imu.csv", "walk.yaml", "rec.svo2"}) {
    add(name, "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 45183443\n");
    expect_parts(answer(name), {name, "a pointer of Git LFS", "git lfs pull"});
    add(name, "\n<!DOCTYPE html><html><head><title>Sign in</title></head></html>");
    expect_parts(answer(name), {name, "a web page", "login"});
    add(name, "<html>");
    expect_parts(answer(name), {"a web page"});
    add(name, "");
    expect_parts(answer(name), {name, "is empty", "broke off"});
  }
}

// Also where other files of the recording are as they should be.
TEST_F(ForeignKinds, WithinAFolderTheyAreNamedToo) {
  const std::string pointer =
      "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 45183443\n";
  for (const char* name : {"camchain-imucam.yaml", "calibration.json"}) {
    add("images/cam0/5.png");
    add("imu.yaml", "a: 1\n");
    add(name, pointer);
    expect_parts(answer(), {name, "is a pointer of Git LFS", "git lfs pull"});
  }
  for (const char* name : {"walk_0.db3", "walk.mcap"}) {
    add(name, pointer);
    expect_parts(answer(), {name, "is a pointer of Git LFS"});
    add(name, "<!DOCTYPE html><html></html>");
    expect_parts(answer(), {name, "is a web page"});
  }
  add("imu.yaml", "a: 1\n");
  add("log.ulg", "ULog\x01\x12\x35\x01");
  expect_parts(answer(), {"holds log.ulg, which looks like a flight log of PX4"});
  add("rec.svo", "SVO");
  expect_parts(answer(), {"holds rec.svo", "ZED camera"});
  add("images.txt", "# Image list with two lines of data per image:\n");
  expect_parts(answer(), {"holds images.txt", "a model of COLMAP"});
  for (const char* part : {"cameras", "images", "points3D"})
    add(std::string("sparse/0/") + part + ".bin");
  expect_parts(answer(), {"a model of COLMAP (cameras.bin"});
  add("points3D.txt", "# 3D point list with one line of data per point:\n");
  expect_parts(answer("points3D.txt"), {"a part of a model of COLMAP"});
}

// What nobody knows still gets the list of what is read.
TEST_F(ForeignKinds, AnythingElseGetsTheList) {
  add("notes.txt");
  expect_parts(input_error([&] { read_recording(folder); }), {"expected", "docs/formats.md"});
  expect_parts(input_error([&] { read_recording(folder / "notes.txt"); }),
               {"its first bytes are of no known kind", "docs/formats.md"});
}

}  // namespace
}  // namespace chasles
