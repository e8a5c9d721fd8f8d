#include <chasles/data/bag_testing.hpp>
#include <chasles/data/bag_topics.hpp>
#include <chasles/data/readers.hpp>
#include <chasles/data/ros_message.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::compressed_message;
using test::expect_parts;
using test::image_message;
using test::imu_message;
using test::input_error;
using test::kStamp;

const ImageSize kSize{.width = 8, .height = 6};

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

class Bag : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = test::scratch();
    test::write_kalibr(folder);
    test::write_bag(folder / "walk.bag");
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

// librosbag would read beyond its buffers with such lengths.
TEST_F(Bag, LengthsAndOffsetsThatLeadElsewhereAreRefused) {
  const std::string bytes = test::slurp(folder / "walk.bag");
  const auto error = [&](std::size_t at, const std::string& other) {
    std::string changed = bytes;
    test::spill(folder / "walk.bag", changed.replace(at, other.size(), other));
    return input_error([&] { read_recording(folder / "walk.bag"); });
  };
  const std::string kLong("\xff\xff\x00\x00", 4);
  const auto after = [&](const std::string& text, std::size_t from = 0) {
    return bytes.find(text, from) + text.size();
  };
  const std::size_t chunk = bytes.find("compression=none");
  const std::size_t connection = bytes.rfind("topic=/imu0");
  const std::size_t info = bytes.rfind("chunk_pos=");
  for (const std::size_t field : {chunk, connection, info}) {
    expect_parts(error(field - 4, kLong), {"walk.bag", "at byte", "the bag is damaged"});
  }
  expect_parts(error(after("chunk_pos=", info), kLong), {"an index leads to no chunk"});
  expect_parts(error(after("index_pos="), kLong + kLong), {"the index is beyond the end"});
  expect_parts(error(after("conn_count="), kLong), {"walk.bag", "at byte"});
  expect_parts(error(after("compression=none") - 4, "zlib"), {"a chunk's compression or size"});
  const std::size_t message = bytes.rfind("conn=", bytes.find("op=\x02", chunk));
  expect_parts(error(after("conn=", message), kLong), {"connection 65535 is not known"});
  expect_parts(error(8, "V1.2"), {"no bag of the format 2.0"});
}

TEST_F(Bag, EveryByteMayBeWrong) {
  const std::string bytes = test::slurp(folder / "walk.bag");
  int refused = 0;
  for (std::size_t at = 13; at < bytes.size(); at += 3) {
    std::string changed = bytes;
    changed[at] = '\xff';
    test::spill(folder / "walk.bag", changed);
    try {
      read_recording(folder / "walk.bag");
    } catch (const InputError& error) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 300);
}

TEST_F(Bag, DamagedBagsAreRefusedByName) {
  const std::string bytes = test::slurp(folder / "walk.bag");
  for (std::size_t size = 13; size < bytes.size(); size += 1 + bytes.size() / 60) {
    test::spill(folder / "walk.bag", bytes.substr(0, size));
    expect_parts(input_error([&] { read_recording(folder / "walk.bag"); }), {"walk.bag"});
  }
  test::spill(folder / "walk.bag", bytes);
  fs::remove(folder / "camchain-imucam.yaml");
  expect_parts(input_error([&] { read_recording(folder / "walk.bag"); }),
               {"walk.bag", "no camchain-imucam.yaml beside it"});
}

#endif

}  // namespace
}  // namespace chasles
