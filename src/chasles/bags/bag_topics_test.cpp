#include <chasles/bags/bag_testing.hpp>
#include <chasles/bags/bag_topics.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;
using Names = std::vector<std::string>;

const char* const kImage = "sensor_msgs/Image";
const char* const kPacked = "sensor_msgs/CompressedImage";

std::vector<TopicContents> topics(const std::vector<std::pair<std::string, std::string>>& list) {
  std::vector<TopicContents> all;
  for (const auto& [name, type] : list) {
    all.emplace_back();
    all.back().topic = {.name = name, .type = type};
  }
  return all;
}

KalibrCalibration chain(const Names& names, const std::string& imu = "") {
  KalibrCalibration kalibr;
  kalibr.cameras.resize(names.size());
  kalibr.camera_topics = names;
  kalibr.imu_topic = imu;
  return kalibr;
}

const std::vector<TopicContents> kStereo = topics({{"/imu0", "sensor_msgs/Imu"},
                                                   {"/left", kImage},
                                                   {"/left/compressed", kPacked},
                                                   {"/right", kImage},
                                                   {"/tf", "tf/tfMessage"}});

class BagTopics : public ::testing::Test {
 protected:
  ChosenTopics choose(const std::vector<TopicContents>& all, const KalibrCalibration& kalibr) {
    return choose_topics("walk.bag", all, &kalibr, {folder});
  }
  static Names names(const ChosenTopics& chosen) {
    Names all;
    for (const TopicContents* topic : chosen.cameras) all.push_back(topic->topic.name);
    return all;
  }
  fs::path folder = test::scratch();
};

TEST_F(BagTopics, AreThoseThatTheCalibrationNames) {
  const ChosenTopics chosen = choose(kStereo, chain({"/right", "left"}, "/imu0"));
  EXPECT_EQ(chosen.imu->topic.name, "/imu0");
  EXPECT_EQ(names(chosen), (Names{"/right", "/left"}));
  EXPECT_EQ(chosen.chain, (std::vector<std::size_t>{0, 1}));
  EXPECT_TRUE(chosen.remarks.empty());
  EXPECT_EQ(names(choose(kStereo, chain({"/left/compressed"}))), Names{"/left/compressed"});
}

// Kalibr took the raw topics; the bag has their compressed copies, whose names sort the other way.
TEST_F(BagTopics, CompressedCopiesAreMatchedByName) {
  const auto packed = topics({{"/imu0", "sensor_msgs/Imu"},
                              {"/left/image_raw/compressed", kPacked},
                              {"/right/image_raw/compressed", kPacked}});
  EXPECT_EQ(names(choose(packed, chain({"/right/image_raw", "/left/image_raw"}))),
            (Names{"/right/image_raw/compressed", "/left/image_raw/compressed"}));
  EXPECT_EQ(names(choose(kStereo, chain({"/right/compressed"}))), Names{"/right"});
}

TEST_F(BagTopics, ACameraThatIsNotThereIsLeftOutWithARemark) {
  const ChosenTopics chosen = choose(kStereo, chain({"/front", "/right"}));
  EXPECT_EQ(names(chosen), Names{"/right"});
  EXPECT_EQ(chosen.chain, std::vector<std::size_t>{1});
  ASSERT_EQ(chosen.remarks.size(), 1u);
  expect_parts(chosen.remarks[0], {"cam0", "left out", "/front", "/left (sensor_msgs/Image)"});
}

TEST_F(BagTopics, TheOnlyOnesAndTheNamesOfTheCamerasNeedNoTopicInTheCalibration) {
  const auto one = topics({{"/camera/image", kImage}, {"/mavros/imu", "sensor_msgs/Imu"}});
  const ChosenTopics chosen = choose(one, chain({"/cam0/image_raw"}, "/imu0"));
  EXPECT_EQ(names(chosen), Names{"/camera/image"});
  ASSERT_EQ(chosen.remarks.size(), 2u);
  expect_parts(chosen.remarks[0], {"no topic /imu0", "/mavros/imu"});
  expect_parts(chosen.remarks[1], {"no topic /cam0/image_raw", "/camera/image"});
  const auto numbered =
      topics({{"/a/cam1/image", kImage}, {"/b/cam0/image", kImage}, {"/imu0", "sensor_msgs/Imu"}});
  EXPECT_EQ(names(choose(numbered, chain({"", ""}))), (Names{"/b/cam0/image", "/a/cam1/image"}));
}

// The order of names was taken for that of the cameras: then left and right were swapped.
TEST_F(BagTopics, AnOrderIsNeverAssumed) {
  const auto error = [&](const KalibrCalibration& kalibr) {
    return input_error([&] { choose(kStereo, kalibr); });
  };
  expect_parts(error(chain({"", ""})), {"walk.bag", "/left (sensor_msgs/Image)", "topics.yaml"});
  expect_parts(error(chain({"/a", "/b"})), {"the calibration has cam0 (/a), cam1 (/b)"});
  expect_parts(error(chain({""})), {"expected topics of images with the names"});
}

TEST_F(BagTopics, AFileHasPrecedence) {
  test::spill(folder / "topics.yaml", "imu: /imu0\ncameras: [/right, /left/compressed]\n");
  EXPECT_EQ(names(choose(kStereo, chain({"/left", "/right"}))),
            (Names{"/right", "/left/compressed"}));
  EXPECT_EQ(names(choose_topics("walk.bag", kStereo, nullptr, {folder})),
            (Names{"/right", "/left/compressed"}));
  test::spill(folder / "topics.yaml", "imu: /imu1\ncameras: [/right]\n");
  expect_parts(input_error([&] { choose(kStereo, chain({""})); }),
               {"expected the topic /imu1 of sensor_msgs/Imu"});
  test::spill(folder / "topics.yaml", "imu: /imu0\ncameras: [/right]\n");
  expect_parts(input_error([&] { choose(kStereo, chain({"", ""})); }), {"expected 2 cameras"});
}

// Images at 0, 1, 2, … ms.
void add_images(TopicContents& topic, int count, int step = 1) {
  for (int i = 0; i < count; i += step) {
    topic.images.push_back({.time = std::chrono::milliseconds(i)});
  }
}

// The disk was too slow for the raw images: two of three were lost.
TEST_F(BagTopics, OfCopiesTheFullestIsTaken) {
  std::vector<TopicContents> all = kStereo;
  add_images(all[1], 120, 3);
  add_images(all[2], 120);
  add_images(all[3], 120);
  for (const KalibrCalibration& kalibr :
       {chain({"/left", "/right"}), chain({"/left/compressed", "/right"})}) {
    const ChosenTopics chosen = choose(all, kalibr);
    EXPECT_EQ(names(chosen), (Names{"/left/compressed", "/right"}));
    if (kalibr.camera_topics[0] == "/left/compressed") continue;
    ASSERT_EQ(chosen.remarks.size(), 1u);
    expect_parts(chosen.remarks[0], {"/left has images at 40 times", "/left/compressed at 120",
                                     "the images of /left/compressed are taken"});
  }
  const ChosenTopics without = choose_topics("walk.bag", all, nullptr, {folder});
  EXPECT_EQ(names(without), (Names{"/left/compressed", "/right"}));
  test::spill(folder / "topics.yaml", "imu: /imu0\ncameras: [/left, /right]\n");
  EXPECT_EQ(names(choose(all, chain({"", ""}))), (Names{"/left", "/right"})) << "as it was asked";
}

// The other way round, and repeated stamps count once.
TEST_F(BagTopics, OfCopiesThatAreAsFullTheRawOneStays) {
  std::vector<TopicContents> all = kStereo;
  add_images(all[1], 120);
  add_images(all[2], 120);
  add_images(all[2], 120);
  EXPECT_EQ(choose(all, chain({"/left"})).remarks.size(), 0u);
  all[2].images.push_back({.time = std::chrono::seconds(1)});
  const ChosenTopics nearly = choose(all, chain({"/left"}));
  EXPECT_EQ(names(nearly), Names{"/left"}) << "one image in 121 is not worth lossy ones";
  expect_parts(nearly.remarks.at(0), {"at 120 times", "at 121", "of /left are taken"});
  all[2].images.resize(10);
  EXPECT_EQ(names(choose(all, chain({"/left/compressed"}))), Names{"/left"});
}

TEST_F(BagTopics, AVideoIsRejectedInOneLine) {
  auto all = topics({{"/imu0", "sensor_msgs/Imu"},
                     {"/left/ffmpeg", "ffmpeg_image_transport_msgs/FFMPEGPacket"},
                     {"/depth", kImage}});
  all[1].format = "libx264";
  const auto error = [&](const KalibrCalibration& kalibr) {
    return input_error([&] { choose(all, kalibr); });
  };
  expect_parts(
      error(chain({"/left"})),
      {"walk.bag: /left/ffmpeg is libx264 video (ffmpeg_image_transport_msgs/FFMPEGPacket)",
       "republish ffmpeg raw", "out:=/left"});
  all = topics({{"/imu0", "sensor_msgs/Imu"}, {"/left/compressed", kPacked}});
  all[1].format = "h264";
  expect_parts(error(chain({"/left"})), {"/left/compressed is h264 video", "the format 'h264'",
                                         "ffmpeg -i cam0.h264", "-start_number 0"});
  expect_parts(error(chain({""})), {"h264 video"});
  test::spill(folder / "topics.yaml", "imu: /imu0\ncameras: [/left/compressed]\n");
  expect_parts(error(chain({""})), {"h264 video"});
  fs::remove(folder / "topics.yaml");
  all.push_back(topics({{"/right", kImage}})[0]);
  const ChosenTopics one = choose(all, chain({"/left", "/right"}));
  EXPECT_EQ(names(one), Names{"/right"});
  expect_parts(one.remarks.at(0), {"cam0 of the calibration is left out", "h264 video"});
}

TEST_F(BagTopics, WhatIsMissingIsNamed) {
  const auto error = [&](const std::vector<TopicContents>& all) {
    return input_error([&] { choose(all, chain({""})); });
  };
  expect_parts(error(topics({{"/left", kImage}})), {"expected one topic of sensor_msgs/Imu"});
  expect_parts(error(topics({{"/imu0", "sensor_msgs/Imu"}})),
               {"expected a topic of sensor_msgs/I"});
  expect_parts(error({}), {"holds no message"});
  const auto many =
      topics({{"/a", kImage}, {"/b", kImage}, {"/c", kImage}, {"/imu0", "sensor_msgs/Imu"}});
  expect_parts(input_error([&] { choose_topics("walk.bag", many, nullptr, {folder}); }),
               {"expected one or two topics of images"});
}

}  // namespace
}  // namespace chasles
