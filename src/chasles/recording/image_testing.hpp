#pragma once

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>  // IMREAD_*, IMWRITE_*

#include <chasles/base/opencv_codecs_testing.hpp>
#include <chasles/codec/image_decode.hpp>
#include <chasles/recording/testing.hpp>

// Small recordings of images for the tests of their readers.
namespace chasles::test {

/// A picture whose grey is `shade` plus the column's number, 8 columns wide and 6 rows high.
inline cv::Mat picture(int shade, int width = 8, int height = 6) {
  cv::Mat image(height, width, CV_8UC1);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      image.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>((shade + u) % 256);
    }
  }
  return image;
}

inline std::string encoded(const cv::Mat& image, const std::string& ending = ".png") {
  const std::vector<std::uint8_t> bytes = opencv_encoded(ending, image);
  return {bytes.begin(), bytes.end()};
}

/// Decoded by us, whatever size it states; and by OpenCV, in the way that it was read before.
inline GrayImage decoded(const std::string& bytes, int bits = kAllBits) {
  return decode_image(bytes, stated_size(bytes, "file"), "file", bits);
}
inline GrayImage decoded_by_opencv(const std::string& bytes) {
  const cv::Mat image = opencv_decoded({bytes.begin(), bytes.end()},
                                       cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  return {.width = image.cols, .height = image.rows, .pixels = {image.datastart, image.dataend}};
}

/// Of the shades of two images; 256 if their sizes differ.
inline int largest_difference(const GrayImage& a, const GrayImage& b) {
  int most = 0;
  if (a.width != b.width || a.height != b.height || a.pixels.size() != b.pixels.size()) return 256;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    most = std::max(most, std::abs(int{a.pixels[i]} - int{b.pixels[i]}));
  }
  return most;
}

inline std::string picture_bytes(int shade) { return encoded(picture(shade)); }

inline const char* const kEurocCamera0 =
    "%YAML:1.0\n#General sensor definitions.\nsensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n"
    "  data: [0, -1, 0, 0.1, 1, 0, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, 1]\n"
    "resolution: [8, 6]\ncamera_model: pinhole\nintrinsics: [4, 4.5, 3.5, 2.5] #fu\n"
    "distortion_model: radial-tangential\ndistortion_coefficients: [-0.28, 0.07, 1e-4, 2e-5]\n";
inline const char* const kEurocImu0 =
    "sensor_type: imu\nT_BS:\n  cols: 4\n  rows: 4\n"
    "  data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nrate_hz: 200\n"
    "gyroscope_noise_density: 1e-4\ngyroscope_random_walk: 2e-5\n"
    "accelerometer_noise_density: 2e-3\naccelerometer_random_walk: 3e-3\n";
inline const char* const kEurocImuColumns =
    "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
    "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n";
inline const char* const kEurocStateColumns =
    "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], "
    "q_RS_z [], v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], b_w_RS_S_x [rad s^-1], "
    "b_w_RS_S_y [rad s^-1], b_w_RS_S_z [rad s^-1], b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], "
    "b_a_RS_S_z [m s^-2]\n";

/// Five samples, 5 ms apart from time 0 on, as rows `time,wx,wy,wz,ax,ay,az`.
inline std::string five_samples() {
  std::string rows;
  for (int k = 0; k < 5; ++k) rows += fmt::format("{},0.1,0.2,{},1,2,9.5\n", k * 5'000'000, k);
  return rows;
}

/// Three frames, 5 ms apart from 5 ms on; camera c shows picture(10 + 100 c + frame).
inline constexpr int kFrames = 3;
inline int shade_of(int camera, int frame) { return 10 + 100 * camera + frame; }
inline std::string stamp_of(int frame) { return fmt::format("{}", (frame + 1) * 5'000'000); }

/// An EuRoC folder `rec` with mav0, `cameras` cameras, and the truth.
inline void write_euroc_folder(const std::filesystem::path& rec, int cameras) {
  namespace fs = std::filesystem;
  const fs::path mav = rec / "mav0";
  for (int c = 0; c < cameras; ++c) {
    const fs::path camera = mav / fmt::format("cam{}", c);
    fs::create_directories(camera / "data");
    spill(camera / "sensor.yaml", kEurocCamera0);
    std::string table = "#timestamp [ns],filename\r\n";
    for (int k = 0; k < kFrames; ++k) {
      table += fmt::format("{0},{0}.png\r\n", stamp_of(k));
      spill(camera / "data" / (stamp_of(k) + ".png"), picture_bytes(shade_of(c, k)));
    }
    spill(camera / "data.csv", table);
  }
  fs::create_directories(mav / "imu0");
  spill(mav / "imu0" / "sensor.yaml", kEurocImu0);
  spill(mav / "imu0" / "data.csv", kEurocImuColumns + five_samples());
  fs::create_directories(mav / "state_groundtruth_estimate0");
  spill(mav / "state_groundtruth_estimate0" / "data.csv",
        std::string(kEurocStateColumns) +
            "5000000,1,2,3,1,0,0,0,4,5,6,7,8,9,10,11,12\n"
            "10000000,1,2,4,1,0,0,0,4,5,6,7,8,9,10,11,12\n");
}

}  // namespace chasles::test
