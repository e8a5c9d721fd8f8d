#pragma once

#include <cstring>
#include <filesystem>
#include <string>

#include <chasles/data/image_testing.hpp>

#ifdef CHASLES_HAS_ROSBAG
#include <rosbag/bag.h>
#endif

// Messages of a ROS 1 bag, and a small bag with them.
namespace chasles::test {

template <typename Number>
void put(std::string& bytes, Number number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof(Number));
}

inline void put_text(std::string& bytes, const std::string& text) {
  put(bytes, static_cast<std::uint32_t>(text.size()));
  bytes += text;
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

// `gap` bytes lie between two rows.
inline std::string image_message(Time time, const cv::Mat& image, const std::string& encoding,
                                 std::size_t gap = 0) {
  const std::size_t row = image.total() * image.elemSize() / static_cast<std::size_t>(image.rows);
  std::string bytes = message_header(time), data;
  put(bytes, static_cast<std::uint32_t>(image.rows));
  put(bytes, static_cast<std::uint32_t>(image.cols));
  put_text(bytes, encoding);
  bytes += '\0';
  put(bytes, static_cast<std::uint32_t>(row + gap));
  for (int v = 0; v < image.rows; ++v) {
    data.append(reinterpret_cast<const char*>(image.ptr(v)), row).append(gap, '\x5a');
  }
  put_text(bytes, data);
  return bytes;
}

inline std::string compressed_message(Time time, const std::string& file) {
  std::string bytes = message_header(time);
  put_text(bytes, "png");
  put_text(bytes, file);
  return bytes;
}

inline constexpr Time kStamp =
    std::chrono::seconds(1403636584) + std::chrono::nanoseconds(763555584);

/// Two pinholes of 8 x 6 pixels, 0.1 m apart.
inline const char* const kChain = R"(cam0:
  T_cam_imu: [[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
  camera_model: pinhole
  distortion_model: none
  distortion_coeffs: []
  intrinsics: [4, 4, 3.5, 2.5]
  resolution: [8, 6]
cam1:
  T_cam_imu: [[1, 0, 0, 0.4], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
  camera_model: pinhole
  distortion_model: none
  distortion_coeffs: []
  intrinsics: [4, 4, 3.5, 2.5]
  resolution: [8, 6]
)";
inline const char* const kKalibrImu =
    "accelerometer_noise_density: 0.01\naccelerometer_random_walk: 0.0002\n"
    "gyroscope_noise_density: 0.005\ngyroscope_random_walk: 4.0e-06\n";

/// Writes Kalibr's two files, as they are beside a bag.
inline void write_kalibr(const std::filesystem::path& folder) {
  spill(folder / "camchain-imucam.yaml", kChain);
  spill(folder / "imu.yaml", kKalibrImu);
}

#ifdef CHASLES_HAS_ROSBAG

/// The bytes of a message whose type is named at run time.
struct RawMessage {
  std::string type;
  std::string bytes;
};

}  // namespace chasles::test

namespace ros::message_traits {
template <>
struct IsMessage<chasles::test::RawMessage> : TrueType {};
template <>
struct MD5Sum<chasles::test::RawMessage> {
  static const char* value(const chasles::test::RawMessage&) {
    return "00000000000000000000000000000000";
  }
};
template <>
struct DataType<chasles::test::RawMessage> {
  static const char* value(const chasles::test::RawMessage& m) { return m.type.c_str(); }
};
template <>
struct Definition<chasles::test::RawMessage> {
  static const char* value(const chasles::test::RawMessage&) { return ""; }
};
}  // namespace ros::message_traits

namespace ros::serialization {
template <>
struct Serializer<chasles::test::RawMessage> {
  template <typename Stream>
  static void write(Stream& stream, const chasles::test::RawMessage& m) {
    std::memcpy(stream.advance(static_cast<std::uint32_t>(m.bytes.size())), m.bytes.data(),
                m.bytes.size());
  }
  static std::uint32_t serializedLength(const chasles::test::RawMessage& m) {
    return static_cast<std::uint32_t>(m.bytes.size());
  }
};
}  // namespace ros::serialization

namespace chasles::test {

/// Five samples, three raw images of cam0, two compressed ones of cam1. Recording times are later
/// than the stamps.
inline void write_bag(const std::filesystem::path& file) {
  rosbag::Bag bag(file.string(), rosbag::bagmode::Write);
  const auto add = [&](const std::string& topic, const std::string& type, Time time,
                       const std::string& bytes) {
    const Time recorded = time + std::chrono::milliseconds(3);
    bag.write(topic,
              ros::Time(static_cast<std::uint32_t>(recorded.count() / 1'000'000'000),
                        static_cast<std::uint32_t>(recorded.count() % 1'000'000'000)),
              RawMessage{.type = type, .bytes = bytes});
  };
  for (int k = 0; k < 5; ++k) {
    const Time time = kStamp + std::chrono::milliseconds(5 * k);
    add("/imu0", "sensor_msgs/Imu", time,
        imu_message({.time = time, .specific_force_imu = {0, 0, 9.0 + k}}));
  }
  for (int k = 0; k < 3; ++k) {
    const Time time = kStamp + std::chrono::milliseconds(5 * k);
    add("/cam0/image_raw", "sensor_msgs/Image", time,
        image_message(time, picture(shade_of(0, k)), "mono8"));
    if (k == 1) continue;
    add("/cam1/image_raw/compressed", "sensor_msgs/CompressedImage", time,
        compressed_message(time, picture_bytes(shade_of(1, k))));
  }
  bag.close();
}

#endif

}  // namespace chasles::test
