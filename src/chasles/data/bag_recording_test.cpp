#include <chasles/data/bag_topics.hpp>
#include <chasles/data/image_testing.hpp>
#include <chasles/data/readers.hpp>
#include <chasles/data/ros_message.hpp>

#ifdef CHASLES_HAS_ROSBAG
#include <rosbag/bag.h>
#endif

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;

template <typename Number>
void put(std::string& bytes, Number number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof(Number));
}

void put_text(std::string& bytes, const std::string& text) {
  put(bytes, static_cast<std::uint32_t>(text.size()));
  bytes += text;
}

std::string header(Time time) {
  std::string bytes;
  put(bytes, std::uint32_t{7});
  put(bytes, static_cast<std::uint32_t>(time.count() / 1'000'000'000));
  put(bytes, static_cast<std::uint32_t>(time.count() % 1'000'000'000));
  put_text(bytes, "cam");
  return bytes;
}

std::string imu_message(const ImuSample& s) {
  std::string bytes = header(s.time);
  for (int i = 0; i < 13; ++i) put(bytes, 0.5);
  for (const double w : s.angular_rate_imu) put(bytes, w);
  for (int i = 0; i < 9; ++i) put(bytes, 0.25);
  for (const double a : s.specific_force_imu) put(bytes, a);
  for (int i = 0; i < 9; ++i) put(bytes, 0.125);
  return bytes;
}

// `gap` bytes lie between two rows.
std::string image_message(Time time, const cv::Mat& image, const std::string& encoding,
                          std::size_t gap = 0) {
  const std::size_t row = image.total() * image.elemSize() / static_cast<std::size_t>(image.rows);
  std::string bytes = header(time), data;
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

std::string compressed_message(Time time, const std::string& file) {
  std::string bytes = header(time);
  put_text(bytes, "png");
  put_text(bytes, file);
  return bytes;
}

const ImageSize kSize{.width = 8, .height = 6};
constexpr Time kStamp = std::chrono::seconds(1403636584) + std::chrono::nanoseconds(763555584);

TEST(RosMessage, AnImuIsReadFieldByField) {
  const ImuSample sent{
      .time = kStamp, .specific_force_imu = {1, -2, 9.5}, .angular_rate_imu = {0.1, 0.2, -0.3}};
  const ImuSample read = ros_imu(imu_message(sent), "imu");
  EXPECT_EQ(read.time, sent.time);
  EXPECT_EQ(read.specific_force_imu, sent.specific_force_imu);
  EXPECT_EQ(read.angular_rate_imu, sent.angular_rate_imu);
}

TEST(RosMessage, ImagesOfEveryEncodingBecomeGrey) {
  const cv::Mat grey = test::picture(40);
  for (const std::size_t gap : {0u, 5u}) {
    const GrayImage image = ros_image(image_message(kStamp, grey, "mono8", gap), kSize, "image");
    ASSERT_EQ(image.pixels.size(), 48u);
    EXPECT_EQ(image.pixels[47], 47);
  }
  cv::Mat colour(6, 8, CV_8UC3, cv::Scalar(10, 100, 200));
  // 0.114 * 10 + 0.587 * 100 + 0.299 * 200 = 119.64
  EXPECT_EQ(ros_image(image_message(kStamp, colour, "bgr8"), kSize, "image").pixels[5], 120);
  // 0.114 * 200 + 0.587 * 100 + 0.299 * 10 = 84.49
  EXPECT_EQ(ros_image(image_message(kStamp, colour, "rgb8"), kSize, "image").pixels[5], 84);
  const std::string file = test::encoded(grey);
  EXPECT_EQ(ros_compressed_image(compressed_message(kStamp, file), kSize, "image").pixels[47], 47);
}

TEST(RosMessage, EveryTruncationIsRefused) {
  const std::string imu = imu_message({.time = kStamp});
  const std::string image = image_message(kStamp, test::picture(40), "mono8");
  for (std::size_t size = 0; size < imu.size(); ++size) {
    expect_parts(input_error([&] { ros_imu(imu.substr(0, size), "imu"); }), {"imu: ", "truncated"});
  }
  for (std::size_t size = 0; size < image.size(); ++size) {
    expect_parts(input_error([&] { ros_image(image.substr(0, size), kSize, "image"); }),
                 {"truncated"});
  }
}

TEST(RosMessage, WhatIsNoImageOfTheCameraIsRefused) {
  const cv::Mat deep(6, 8, CV_16UC1, cv::Scalar(5));
  expect_parts(
      input_error([&] { ros_image(image_message(kStamp, deep, "mono16"), kSize, "image"); }),
      {"'mono16'", "expected mono8"});
  expect_parts(input_error([&] {
                 ros_image(image_message(kStamp, test::picture(1, 9, 6), "mono8"), kSize, "image");
               }),
               {"is 9 x 6 pixels, expected 8 x 6"});
  expect_parts(input_error([&] {
                 ros_image(image_message(kStamp, test::picture(1), "bgr8"), kSize, "image");
               }),
               {"holds 48 bytes in rows of 8"});
  ImuSample bad{.time = kStamp};
  bad.angular_rate_imu.y() = std::nan("");
  expect_parts(input_error([&] { ros_imu(imu_message(bad), "imu"); }), {"angular_velocity is nan"});
}

const std::vector<BagTopic> kTopics{{"/imu0", "sensor_msgs/Imu"},
                                    {"/right", "sensor_msgs/Image"},
                                    {"/left", "sensor_msgs/Image"},
                                    {"/left/compressed", "sensor_msgs/CompressedImage"},
                                    {"/tf", "tf/tfMessage"}};

TEST(BagTopics, AreChosenByTypeByCalibrationOrByFile) {
  const fs::path bag = test::scratch() / "walk.bag";
  KalibrCalibration two{.cameras = {Camera{}, Camera{}}, .camera_topics = {"", ""}};
  ChosenTopics chosen = choose_topics(bag, kTopics, two);
  EXPECT_EQ(chosen.imu, "/imu0");
  EXPECT_EQ(chosen.cameras, (std::vector<std::string>{"/left", "/right"}));
  KalibrCalibration named = two;
  named.camera_topics = {"/right", "/left/compressed"};
  named.imu_topic = "/imu0";
  EXPECT_EQ(choose_topics(bag, kTopics, named).cameras, named.camera_topics);
  test::spill(bag.parent_path() / "topics.yaml", "imu: /imu0\ncameras: [/right, /left]\n");
  chosen = choose_topics(bag, kTopics, named);
  EXPECT_EQ(chosen.cameras, (std::vector<std::string>{"/right", "/left"}));
}

TEST(BagTopics, WhatCannotBeChosenIsRefusedWithWhatThereIs) {
  const fs::path bag = test::scratch() / "walk.bag";
  const KalibrCalibration one{.cameras = {Camera{}}, .camera_topics = {""}};
  const auto error = [&](const std::vector<BagTopic>& topics) {
    return input_error([&] { choose_topics(bag, topics, one); });
  };
  expect_parts(error(kTopics), {"walk.bag", "/left (sensor_msgs/Image)", "expected 1 topic of"});
  expect_parts(error({{"/left", "sensor_msgs/Image"}}), {"expected one topic of sensor_msgs/Imu"});
  expect_parts(error({}), {"holds no topic"});
  test::spill(bag.parent_path() / "topics.yaml", "imu: /imu1\ncameras: [/right]\n");
  expect_parts(error(kTopics), {"expected the topic /imu1"});
  test::spill(bag.parent_path() / "topics.yaml", "imu: /imu0\ncameras: [/right, /left]\n");
  expect_parts(error(kTopics), {"expected 1 cameras"});
}

#ifndef CHASLES_HAS_ROSBAG

TEST(Bag, WithoutTheLibraryThePackageIsNamed) {
  const fs::path bag = test::scratch() / "walk.bag";
  test::spill(bag, "#ROSBAG V2.0\n");
  expect_parts(input_error([&] { read_recording(bag); }), {"walk.bag", "librosbag-storage-dev"});
}

#else

/// The bytes of a message of a type that is named at run time.
struct RawMessage {
  std::string type;
  std::string bytes;
};

}  // namespace
}  // namespace chasles

namespace ros::message_traits {
template <>
struct IsMessage<chasles::RawMessage> : TrueType {};
template <>
struct MD5Sum<chasles::RawMessage> {
  static const char* value(const chasles::RawMessage&) {
    return "00000000000000000000000000000000";
  }
};
template <>
struct DataType<chasles::RawMessage> {
  static const char* value(const chasles::RawMessage& m) { return m.type.c_str(); }
};
template <>
struct Definition<chasles::RawMessage> {
  static const char* value(const chasles::RawMessage&) { return ""; }
};
}  // namespace ros::message_traits

namespace ros::serialization {
template <>
struct Serializer<chasles::RawMessage> {
  template <typename Stream>
  static void write(Stream& stream, const chasles::RawMessage& m) {
    std::memcpy(stream.advance(static_cast<std::uint32_t>(m.bytes.size())), m.bytes.data(),
                m.bytes.size());
  }
  static std::uint32_t serializedLength(const chasles::RawMessage& m) {
    return static_cast<std::uint32_t>(m.bytes.size());
  }
};
}  // namespace ros::serialization

namespace chasles {
namespace {

const char* const kChain = R"(cam0:
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

class Bag : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = test::scratch();
    test::spill(folder / "camchain-imucam.yaml", kChain);
    test::spill(folder / "imu.yaml",
                "accelerometer_noise_density: 0.01\naccelerometer_random_walk: 0.0002\n"
                "gyroscope_noise_density: 0.005\ngyroscope_random_walk: 4.0e-06\n");
    write();
  }
  // Five samples, three raw images of cam0, two compressed ones of cam1; recorded later than
  // stamped.
  void write() const {
    rosbag::Bag bag((folder / "walk.bag").string(), rosbag::bagmode::Write);
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
          image_message(time, test::picture(test::shade_of(0, k)), "mono8"));
      if (k == 1) continue;
      add("/cam1/image_raw/compressed", "sensor_msgs/CompressedImage", time,
          compressed_message(time, test::picture_bytes(test::shade_of(1, k))));
    }
    bag.close();
  }
  fs::path folder;
};

TEST_F(Bag, WhatIsWrittenIsReadBack) {
  const Recording r = read_recording(folder / "walk.bag");
  EXPECT_EQ(r.name, "walk");
  ASSERT_EQ(r.imu.size(), 5u);
  EXPECT_EQ(r.imu[3].time, kStamp + std::chrono::milliseconds(15)) << "the message's own stamp";
  EXPECT_EQ(r.imu[3].specific_force_imu.z(), 12);
  EXPECT_EQ(r.cameras[1].cam_T_imu.p.x(), 0.4);
  ASSERT_EQ(r.images->size(), 3u);
  for (const std::size_t k : {2u, 0u, 1u}) {
    const ImageFrame frame = r.images->read(k);
    EXPECT_EQ(frame.time, kStamp + std::chrono::milliseconds(5 * k));
    EXPECT_EQ(frame.images[0].pixels[3], test::shade_of(0, static_cast<int>(k)) + 3);
    ASSERT_EQ(frame.images[1].empty(), k == 1);
    if (k != 1) {
      EXPECT_EQ(frame.images[1].pixels[3], test::shade_of(1, static_cast<int>(k)) + 3);
    }
  }
  ASSERT_EQ(r.remarks.size(), 1u);
  expect_parts(r.remarks[0], {"1 of 3 frames have an image of only some"});
}

TEST_F(Bag, DamagedBagsAreRefusedByName) {
  const std::string bytes = test::slurp(folder / "walk.bag");
  for (std::size_t size = 13; size < bytes.size(); size += 1 + bytes.size() / 60) {
    test::spill(folder / "walk.bag", bytes.substr(0, size));
    expect_parts(input_error([&] { read_recording(folder / "walk.bag"); }), {"walk.bag"});
  }
  fs::remove(folder / "camchain-imucam.yaml");
  expect_parts(input_error([&] { read_recording(folder / "walk.bag"); }),
               {"walk.bag", "no camchain-imucam.yaml beside it"});
}

#endif

}  // namespace
}  // namespace chasles
