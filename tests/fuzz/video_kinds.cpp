#include <chasles/bags/bag_testing.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/video/gpmf.hpp>
#include <chasles/video/gpmf_testing.hpp>
#include <chasles/video/picture_testing.hpp>
#include <chasles/video/telemetry.hpp>

#include "kinds.hpp"
#include "parts.hpp"
#include "use_recording.hpp"

namespace chasles::fuzz {
namespace {

namespace fs = std::filesystem;

const char* const kVideoCalibration =
    "format: chasles-recording-1\nname: walk\ncameras:\n  - resolution: [32, 24]\n"
    "    intrinsics: [20, 20, 15.5, 11.5]\n    distortion_model: none\n    cam_T_imu:\n"
    "      - [1, 0, 0, 0]\n      - [0, 1, 0, 0]\n      - [0, 0, 1, 0]\n"
    "      - [0, 0, 0, 1]\nimu_convention: instant\n";

// A payload of 20 samples of both sensors, from the n-th one on, and of one picture.
std::string seed_payload(unsigned first) {
  const auto stream = [&](const std::string& key, const std::string& unit) {
    std::vector<std::vector<int>> rows;
    for (int i = 0; i < 20; ++i) rows.push_back({950, 10 * i, 20});
    return test::nest("STRM", test::klv_stamp("STMP", 1000 + 5000 * first) +
                                  test::klv_count("TSMP", first + 20) +
                                  test::klv_text("SIUN", unit) +
                                  test::klv_matrix("MTRX", {0, -1, 0, 1, 0, 0, 0, 0, 1}) +
                                  test::klv_text("ORIN", "XzY") + test::klv_text("ORIO", "ZXY") +
                                  test::klv_shorts("SCAL", {{100}}) + test::klv_shorts(key, rows));
  };
  const std::string shutter = test::nest("STRM", test::klv_stamp("STMP", 1000 + 5000 * first) +
                                                     test::klv_count("TSMP", first / 10 + 2) +
                                                     test::klv_shorts("SHUT", {{1}, {1}}));
  return test::nest("DEVC", test::klv_count("DVID", 1) + test::klv_text("DVNM", "Camera") +
                                stream("ACCL", "m/s\xb2") + stream("GYRO", "rad/s") + shutter);
}

std::string telemetry_seed(const fs::path&) {
  return pack({{"0", seed_payload(0)}, {"1", seed_payload(20)}, {"2", seed_payload(40)}});
}

// The parts are the payloads of a video of six pictures.
void read_telemetry_parts(const fs::path&, std::string_view bytes) {
  VideoIndex index;
  index.file = "walk.mp4";
  for (int i = 0; i < 6; ++i) {
    index.pictures.push_back({.time = std::chrono::milliseconds(50 * i), .pts = i});
  }
  for (const auto& [name, payload] : unpack(bytes)) {
    const Time time = std::chrono::milliseconds(100 * index.telemetry.size());
    index.telemetry.push_back(
        {.time = time, .duration = std::chrono::milliseconds(100), .bytes = payload});
  }
  std::vector<std::string> remarks;
  read_telemetry(index, remarks);
  for (const TelemetryPayload& payload : index.telemetry) {  // it leaves damaged ones out
    gpmf_streams(payload.bytes, {"ACCL", "GYRO"}, index.file);
  }
}

std::vector<ImageFrame> seed_pictures() {
  std::vector<ImageFrame> pictures;
  for (int i = 0; i < 6; ++i) {
    pictures.push_back(
        {.time = std::chrono::milliseconds(50 * i), .images = {test::moving_picture(i, 32, 24)}});
  }
  return pictures;
}

std::string video_seed(const fs::path& scratch) {
  fs::create_directories(scratch / "seed");
  std::vector<test::TimedBytes> telemetry;
  for (unsigned k = 0; k < 3; ++k) {
    telemetry.push_back({.time = std::chrono::milliseconds(100 * k),
                         .duration = std::chrono::milliseconds(100),
                         .bytes = seed_payload(20 * k)});
  }
  // What is mutated are boxes rather than pictures.
  test::VideoWriter::write(scratch / "seed/walk.mp4", seed_pictures(),
                           {.options = "crf=45", .key_every = 3, .index_first = true}, telemetry);
  return test::slurp(scratch / "seed/walk.mp4");
}

void read_video(const fs::path& scratch, std::string_view bytes) {
  fs::create_directories(scratch / "input");
  test::spill(scratch / "input/calibration.yaml", kVideoCalibration);
  test::spill(scratch / "input/walk.mp4", std::string(bytes));
  use(read_video_recording(scratch / "input/walk.mp4"));
}

// JSON beside a video that is not changed.
std::string gopro_json_seed(const fs::path&) {
  const auto stream = [](const std::string& about) {
    std::string samples;
    for (int i = 0; i < 12; ++i) {
      samples += fmt::format(R"({}{{"value":[9.5,{},0.2],"cts":{},"date":"2024"}})",
                             i > 0 ? "," : "", 0.1 * i, 20 * i);
    }
    return fmt::format(R"({{"samples":[{}],{}}})", samples, about);
  };
  return fmt::format(R"({{"1":{{"streams":{{"ACCL":{},"GYRO":{}}},"device name":"Camera"}}}})",
                     stream(R"("name":"Accelerometer","units":"m/s2")"),
                     stream(R"~("name":"Gyroscope (z,x,y)","units":"rad/s")~"));
}

void read_gopro_json_bytes(const fs::path& scratch, std::string_view bytes) {
  const fs::path folder = scratch / "input";
  if (!fs::exists(folder / "walk.mp4")) {
    fs::create_directories(folder);
    test::spill(folder / "calibration.yaml", kVideoCalibration);
    test::VideoWriter::write(folder / "walk.mp4", seed_pictures());
  }
  test::spill(folder / "imu_data.json", std::string(bytes));
  use(read_video_recording(folder));
}

}  // namespace

std::vector<Kind> video_kinds() {
  return {
      {"telemetry", telemetry_seed, read_telemetry_parts},
      {"video", video_seed, read_video},
      {"gopro_json", gopro_json_seed, read_gopro_json_bytes},
  };
}

}  // namespace chasles::fuzz
