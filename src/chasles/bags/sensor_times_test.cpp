#include <algorithm>

#include <fmt/format.h>

#include <chasles/bags/bag_testing.hpp>
#include <chasles/bags/sensor_times.hpp>

namespace chasles {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using test::expect_parts;

// What the package pyrealsense2 wrote (tools/test-depth-camera-bag).
TEST(SensorTimes, OfARecordingByTheSdkAreTaken) {
  const BagContents contents = scan_bags({test::written_bag("depth_camera.db3")});
  const Time begin(1403636584763555664);
  std::size_t samples = 0, images = 0;
  for (const TopicContents& topic : contents.topics) {
    for (std::size_t k = 0; k < topic.imu.size(); ++k, ++samples) {
      EXPECT_EQ(topic.imu[k].time, begin + static_cast<int>(k) * milliseconds(5));
    }
    for (std::size_t k = 0; k < topic.images.size(); ++k, ++images) {
      EXPECT_EQ(topic.images[k].time, begin + static_cast<int>(k) * milliseconds(20));
    }
  }
  EXPECT_EQ(samples, 32u);
  EXPECT_EQ(images, 4u);
  ASSERT_EQ(contents.remarks.size(), 1u);
  expect_parts(contents.remarks[0],
               {"/device_0/sensor_0/Infrared_1/image/data/compressed", "Gyro_0/imu/data",
                "is the time of arrival", "(Global Time) are taken"});
}

Time arrival_of(int k) { return k * milliseconds(10) + (k % 7) * microseconds(900); }
Time sensor_of(int k) { return test::kStamp + k * milliseconds(10); }

TopicContents samples(const std::string& name, int count) {
  TopicContents topic;
  topic.topic = {.name = name, .type = "sensor_msgs/Imu"};
  for (int k = 0; k < count; ++k) topic.imu.push_back({.time = arrival_of(k)});
  return topic;
}

class MadeTimes : public ::testing::Test {
 protected:
  void add(const std::string& topic, int k, const std::string& text) {
    std::string bytes;
    test::put_text(bytes, text);
    times.add({.name = topic, .type = "std_msgs/String"}, {.bytes = bytes}, arrival_of(k));
  }
  void apply() { times.apply(topics, remarks); }

  SensorTimes times;
  std::vector<TopicContents> topics{samples("/d/a/imu/data", 50), samples("/d/b/imu/data", 50)};
  std::vector<std::string> remarks;
};

// The unit is that in which they last as long as the recording.
TEST_F(MadeTimes, OfAnyUnitAreRead) {
  for (int k = 0; k < 50; ++k) {
    const long long ns = sensor_of(k).count();
    add("/d/a/imu/metadata", k, fmt::format("frame_timestamp={}.{:03}", ns / 1000, ns % 1000));
    add("/d/b/imu/metadata", k,
        fmt::format("Exposure=5;timestamp={}.{:06};", ns / 1000000, ns % 1000000));
  }
  apply();
  for (const TopicContents& topic : topics) {
    for (int k = 0; k < 50; ++k) {
      ASSERT_EQ(topic.imu[static_cast<std::size_t>(k)].time, sensor_of(k)) << topic.topic.name;
    }
  }
  expect_parts(remarks.at(0), {"differ by up to 5.4 ms"});
}

TEST_F(MadeTimes, OfKeysAndValuesAreRead) {
  const BagTopic topic{.name = "/d/a/imu/metadata", .type = "diagnostic_msgs/KeyValue"};
  for (int k = 0; k < 50; ++k) {
    for (const auto& [key, value] :
         {std::pair<std::string, std::string>("timestamp_domain", "Hardware Clock"),
          std::pair<std::string, std::string>("Frame Timestamp", "17"),
          std::pair<std::string, std::string>("timestamp", fmt::format("{}", 5000 + 10 * k))}) {
      std::string bytes;
      test::put_text(bytes, key);
      test::put_text(bytes, value);
      times.add(topic, {.bytes = bytes}, arrival_of(k));
    }
  }
  apply();
  EXPECT_EQ(topics[0].imu[49].time, milliseconds(5490));
  EXPECT_EQ(topics[1].imu[49].time, arrival_of(49)) << "it has no such topic";
  expect_parts(remarks.at(0), {"/d/a/imu/data", "(Hardware Clock)"});
}

TEST_F(MadeTimes, OfTwoClocksAreNotMixed) {
  for (int k = 0; k < 50; ++k) {
    const std::string time = fmt::format("timestamp={}.0", 1000 + 10 * k);
    add("/d/a/imu/metadata", k, "timestamp_domain=System Time;" + time);
    add("/d/b/imu/metadata", k, "timestamp_domain=Hardware Clock;" + time);
  }
  apply();
  EXPECT_EQ(topics[0].imu[9].time, arrival_of(9));
  EXPECT_EQ(topics[1].imu[9].time, arrival_of(9));
  expect_parts(remarks.at(0), {"is the time of arrival, which jitters", "not taken", "System Time",
                               "Hardware Clock"});
}

TEST_F(MadeTimes, ThatAreMissingAreCounted) {
  for (int k = 0; k < 50; ++k) {
    const std::string time = fmt::format("timestamp={}", 1000 + 10 * k);
    if (k % 10 != 3) add("/d/a/imu/metadata", k, time);
    add("/d/b/imu/metadata", k, time);
  }
  apply();
  EXPECT_EQ(topics[0].imu.size(), 45u);
  EXPECT_EQ(topics[1].imu.size(), 50u);
  expect_parts(remarks.at(0), {"5 of 100 messages have no such time: left out"});
}

// The stamps of ROS drivers, and of the SDK's bags of ROS 1, are those of the sensor.
TEST_F(MadeTimes, BesideOtherStampsAreIgnored) {
  for (ImuSample& sample : topics[0].imu) sample.time += std::chrono::hours(1);
  for (int k = 0; k < 50; ++k) add("/d/a/imu/metadata", k, fmt::format("timestamp={}", 10 * k));
  apply();
  EXPECT_TRUE(remarks.empty());
  EXPECT_EQ(topics[0].imu[3].time, arrival_of(3) + std::chrono::hours(1));
}

}  // namespace
}  // namespace chasles
