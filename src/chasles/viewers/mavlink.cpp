#include <chasles/base/constants.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/viewers/byte_sink.hpp>
#include <chasles/viewers/mavlink.hpp>

namespace chasles {
namespace {

// common.xml of MAVLink.
constexpr std::uint32_t kOdometry = 331;
constexpr std::uint8_t kOdometryCrcExtra = 91;
constexpr std::uint8_t kLocalFrd = 20, kBodyFrd = 12;  // MAV_FRAME
constexpr std::uint8_t kVisualInertial = 3;            // MAV_ESTIMATOR_TYPE_VIO
constexpr std::uint8_t kSystem = 1;
constexpr std::uint8_t kComponent = 197;  // MAV_COMP_ID_VISUAL_INERTIAL_ODOMETRY

std::int8_t quality_percent(std::string_view health) {
  if (health == "ok") return 100;
  if (health == "degraded") return 50;
  return health == "lost" ? -1 : 0;
}

// CRC-16/MCRF4XX.
std::uint16_t crc16(std::string_view bytes) {
  std::uint16_t crc = 0xffff;
  for (const char byte : bytes) {
    crc = static_cast<std::uint16_t>(crc ^ static_cast<std::uint8_t>(byte));
    for (int bit = 0; bit < 8; ++bit) {
      crc = static_cast<std::uint16_t>((crc & 1) != 0 ? crc >> 1 ^ 0x8408 : crc >> 1);
    }
  }
  return crc;
}

void append_floats(std::string& bytes, const auto& numbers) {
  for (const double number : numbers) append_little_endian(bytes, static_cast<float>(number));
}

void append_upper_triangle(std::string& bytes, const Matrix6d& covariance) {
  for (int i = 0; i < 6; ++i) append_floats(bytes, covariance.row(i).tail(6 - i));
}

Matrix6d velocity_covariance(const FrdOdometry& o) {
  Matrix6d covariance = Matrix6d::Constant(kNaN);
  if (o.velocity_covariance) covariance.topLeftCorner<3, 3>() = *o.velocity_covariance;
  return covariance;
}

std::uint64_t microseconds(Time time) {
  return static_cast<std::uint64_t>(std::chrono::floor<std::chrono::microseconds>(time).count());
}

// The fields in the order of the wire.
std::string odometry_payload(const FrdOdometry& o) {
  std::string bytes;
  append_little_endian(bytes, microseconds(o.time));
  append_floats(bytes, o.local_T_body.p);
  const Eigen::Vector4d q = unit_quaternion(o.local_T_body.R);
  append_floats(bytes, Eigen::Vector4d(q[3], q[0], q[1], q[2]));
  append_floats(bytes, o.v_body);
  append_floats(bytes, o.rate_body);
  append_upper_triangle(bytes, o.pose_covariance);
  append_upper_triangle(bytes, velocity_covariance(o));
  append_little_endian(bytes, kLocalFrd);
  append_little_endian(bytes, kBodyFrd);
  append_little_endian(bytes, o.resets);
  append_little_endian(bytes, kVisualInertial);
  append_little_endian(bytes, quality_percent(o.health));
  return bytes;
}

// A frame of MAVLink 2, without a signature: zeros at the end of the payload are cut.
std::string frame_of(std::string payload, std::uint8_t sequence) {
  while (payload.size() > 1 && payload.back() == 0) payload.pop_back();
  std::string bytes = "\xfd";
  append_little_endian(bytes, static_cast<std::uint8_t>(payload.size()));
  for (const std::uint8_t byte :
       {std::uint8_t{0}, std::uint8_t{0}, sequence, kSystem, kComponent}) {
    append_little_endian(bytes, byte);
  }
  for (const int shift : {0, 8, 16}) {
    append_little_endian(bytes, static_cast<std::uint8_t>(kOdometry >> shift & 0xff));
  }
  bytes += payload;
  const std::string checked = bytes.substr(1) + static_cast<char>(kOdometryCrcExtra);
  append_little_endian(bytes, crc16(checked));
  return bytes;
}

}  // namespace

std::string mavlink_log(std::span<const FrdOdometry> states) {
  std::string log;
  std::uint8_t sequence = 0;
  for (const FrdOdometry& o : states) {
    const std::uint64_t stamp = microseconds(o.time);
    for (int shift = 56; shift >= 0; shift -= 8) log += static_cast<char>(stamp >> shift & 0xff);
    log += frame_of(odometry_payload(o), sequence++);
  }
  return log;
}

}  // namespace chasles
