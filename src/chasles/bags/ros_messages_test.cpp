#include <cmath>

#include <chasles/bags/bag_testing.hpp>
#include <chasles/bags/ros_messages.hpp>

namespace chasles {
namespace {

using test::expect_parts;
using test::input_error;
using test::kStamp;

TEST(RosMessage, AnImuIsReadFieldByField) {
  const ImuSample sent{
      .time = kStamp, .specific_force_imu = {1, -2, 9.5}, .angular_rate_imu = {0.1, 0.2, -0.3}};
  const ImuSample read = ros_imu({.bytes = test::imu_message(sent)});
  EXPECT_EQ(read.time, sent.time);
  EXPECT_EQ(read.specific_force_imu, sent.specific_force_imu);
  EXPECT_EQ(read.angular_rate_imu, sent.angular_rate_imu);
}

// By hand from the specification: a number begins at a multiple of its size, counted from the
// fourth byte on. DDS of a big-endian machine has the other order of bytes.
TEST(RosMessage, CdrIsReadInBothOrdersOfBytes) {
  const auto number = [](std::string& bytes, std::uint64_t value, int size, bool big) {
    while ((bytes.size() - 4) % static_cast<std::size_t>(size) != 0) bytes += '\0';
    for (int i = 0; i < size; ++i) {
      bytes += static_cast<char>(value >> (8 * (big ? size - 1 - i : i)) & 255);
    }
  };
  for (const bool big : {false, true}) {
    std::string bytes(big ? std::string("\0\0\0\0", 4) : std::string("\0\1\0\0", 4));
    number(bytes, 12, 4, big);         // seconds
    number(bytes, 5'000'000, 4, big);  // nanoseconds
    number(bytes, 4, 4, big);          // "imu" and a zero
    bytes += std::string("imu\0", 4);
    for (int i = 0; i < 4 + 9 + 3 + 9 + 3 + 9; ++i) {
      number(bytes, std::bit_cast<std::uint64_t>(0.5 * i), 8, big);
    }
    const RosMessage message{.bytes = bytes, .wire = Wire::kCdr};
    const ImuSample read = ros_imu(message);
    EXPECT_EQ(read.time, std::chrono::milliseconds(12'005));
    EXPECT_EQ(read.angular_rate_imu, Eigen::Vector3d(6.5, 7, 7.5));
    EXPECT_EQ(read.specific_force_imu, Eigen::Vector3d(12.5, 13, 13.5));
    EXPECT_EQ(ros_header(message).frame, "imu");
  }
  EXPECT_THROW(ros_header({.bytes = std::string_view("\0\3\0\0\0\0", 6), .wire = Wire::kCdr}),
               InputError);
}

TEST(RosMessage, EveryTruncationIsRejected) {
  const std::string imu = test::imu_message({.time = kStamp});
  const std::string image = test::image_message(kStamp, test::picture(40), "mono8");
  for (std::size_t size = 0; size < imu.size(); ++size) {
    const RosMessage message{.bytes = std::string_view(imu).substr(0, size), .where = "imu"};
    expect_parts(input_error([&] { ros_imu(message); }), {"imu: ", "truncated"});
  }
  for (std::size_t size = 0; size < image.size(); ++size) {
    const RosMessage message{.bytes = std::string_view(image).substr(0, size)};
    expect_parts(input_error([&] { ros_image(message); }), {"truncated"});
  }
}

// A count of four thousand million elements is not allocated.
TEST(RosMessage, ACountBeyondTheMessageIsRejected) {
  std::string transforms;
  test::put(transforms, std::uint32_t{0xffffffff});
  expect_parts(input_error([&] { ros_transforms({.bytes = transforms}); }),
               {"truncated", "4294967295 elements"});
}

}  // namespace
}  // namespace chasles
