#pragma once

#include <cstring>
#include <filesystem>
#include <string>

#include <chasles/bags/ros_messages.hpp>
#include <chasles/recording/image_testing.hpp>

// Messages of ROS 1, and the bags that independent writers made (tools/test-bags).
namespace chasles::test {

inline constexpr Time kStamp =
    std::chrono::seconds(1403636584) + std::chrono::nanoseconds(763555584);

/// A file or folder of testdata.
inline std::filesystem::path written_bag(const std::string& name) {
  return std::filesystem::path(CHASLES_SOURCE_DIR) / "src/chasles/bags/testdata" / name;
}

template <typename Number>
void put(std::string& bytes, Number number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof(Number));
}

inline void put_text(std::string& bytes, const std::string& text) {
  put(bytes, static_cast<std::uint32_t>(text.size()));
  bytes += text;
}

/// An MCAP file, not closed, of one topic of ROS 1 messages.
inline std::string mcap_of(const std::string& topic, const std::string& type,
                           const std::vector<std::string>& messages) {
  std::string file("\x89MCAP0\r\n", 8);
  const auto record = [&file](int op, const std::string& content) {
    file += static_cast<char>(op);
    put(file, std::uint64_t{content.size()});
    file += content;
  };
  std::string header, schema, channel;
  put_text(header, "ros1");
  put_text(header, "test");
  record(1, header);
  put(schema, std::uint16_t{1});
  for (const std::string& text : {type, std::string("ros1msg"), std::string()}) {
    put_text(schema, text);
  }
  record(3, schema);
  put(channel, std::uint16_t{1});
  put(channel, std::uint16_t{1});
  for (const std::string& text : {topic, std::string("ros1"), std::string()}) {
    put_text(channel, text);
  }
  record(4, channel);
  for (const std::string& bytes : messages) {
    std::string message;
    put(message, std::uint16_t{1});
    put(message, std::uint32_t{0});
    put(message, std::uint64_t{1});
    put(message, std::uint64_t{1});
    record(5, message + bytes);
  }
  return file;
}

inline std::string message_header(Time time) {
  std::string bytes;
  put(bytes, std::uint32_t{7});
  put(bytes, static_cast<std::uint32_t>(time.count() / 1'000'000'000));
  put(bytes, static_cast<std::uint32_t>(time.count() % 1'000'000'000));
  put_text(bytes, "cam");
  return bytes;
}

inline std::string imu_message(const ImuSample& s) {
  std::string bytes = message_header(s.time);
  for (int i = 0; i < 13; ++i) put(bytes, 0.5);
  for (const double w : s.angular_rate_imu) put(bytes, w);
  for (int i = 0; i < 9; ++i) put(bytes, 0.25);
  for (const double a : s.specific_force_imu) put(bytes, a);
  for (int i = 0; i < 9; ++i) put(bytes, 0.125);
  return bytes;
}

/// `gap` bytes lie between two rows.
inline std::string image_message(Time time, const cv::Mat& image, const std::string& encoding,
                                 std::size_t gap = 0, bool big_endian = false) {
  const std::size_t row = image.total() * image.elemSize() / static_cast<std::size_t>(image.rows);
  std::string bytes = message_header(time), data;
  put(bytes, static_cast<std::uint32_t>(image.rows));
  put(bytes, static_cast<std::uint32_t>(image.cols));
  put_text(bytes, encoding);
  bytes += big_endian ? '\1' : '\0';
  put(bytes, static_cast<std::uint32_t>(row + gap));
  for (int v = 0; v < image.rows; ++v) {
    data.append(reinterpret_cast<const char*>(image.ptr(v)), row).append(gap, '\x5a');
  }
  put_text(bytes, data);
  return bytes;
}

/// Two pinholes of 8 x 6 pixels, 0.1 m apart. A test may state topics: `rostopic: …`.
inline std::string kalibr_chain(const std::string& topic0 = "", const std::string& topic1 = "") {
  std::string chain;
  for (int c = 0; c < 2; ++c) {
    const std::string& topic = c == 0 ? topic0 : topic1;
    chain += fmt::format(
        "cam{}:\n  T_cam_imu: [[1, 0, 0, {}], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n"
        "  camera_model: pinhole\n  distortion_model: none\n  distortion_coeffs: []\n"
        "  intrinsics: [4, 4, 3.5, 2.5]\n  resolution: [8, 6]\n{}",
        c, c == 0 ? 0.5 : 0.4, topic.empty() ? "" : "  rostopic: " + topic + "\n");
  }
  return chain;
}
inline const char* const kKalibrImu =
    "accelerometer_noise_density: 0.01\naccelerometer_random_walk: 0.0002\n"
    "gyroscope_noise_density: 0.005\ngyroscope_random_walk: 4.0e-06\n";

/// Writes Kalibr's two files, as they are beside a bag.
inline void write_kalibr(const std::filesystem::path& folder) {
  spill(folder / "camchain-imucam.yaml", kalibr_chain());
  spill(folder / "imu.yaml", kKalibrImu);
}

}  // namespace chasles::test
