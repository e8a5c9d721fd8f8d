#include <Eigen/Geometry>

#include <chasles/bags/bag_imu.hpp>
#include <chasles/bags/bag_testing.hpp>
#include <chasles/bags/bag_topics.hpp>
#include <chasles/recording/readers.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using test::expect_parts;
using test::input_error;
using test::kStamp;

const Eigen::Vector3d kNone = Eigen::Vector3d::Zero();
const Eigen::Vector3d kForce(0.1, 0.2, 9.7), kRate(0.3, -0.2, 0.1);

TopicContents imu_topic(const std::string& name, const Eigen::Vector3d& force,
                        const Eigen::Vector3d& rate) {
  TopicContents topic;
  topic.topic = {.name = name, .type = "sensor_msgs/Imu"};
  topic.no_force = topic.no_rate = false;
  for (int k = 0; k < 3; ++k) {
    topic.imu.push_back({.time = kStamp + k * milliseconds(5),
                         .specific_force_imu = force,
                         .angular_rate_imu = rate});
  }
  return topic;
}

TopicContents images(const std::string& name) {
  TopicContents topic;
  topic.topic = {.name = name, .type = "sensor_msgs/Image"};
  return topic;
}

ChosenTopics choose(const std::vector<TopicContents>& topics, const std::string& imu = "",
                    const fs::path& folder = "nowhere") {
  KalibrCalibration kalibr;
  kalibr.cameras.resize(1);
  kalibr.camera_topics = {"/cam"};
  kalibr.imu_topic = imu;
  return choose_topics("walk.bag", topics, &kalibr, {folder});
}

std::string name_of(const TopicContents* topic) { return topic ? topic->topic.name : ""; }

const std::vector<TopicContents> kApart{imu_topic("/d/accel/sample", kForce, kNone), images("/cam"),
                                        imu_topic("/d/gyro/sample", kNone, kRate)};

TEST(BagImu, PartsAreThoseThatTheSamplesHave) {
  EXPECT_EQ(measured_parts(imu_topic("/a", kForce, kRate)), ImuParts::kBoth);
  EXPECT_EQ(measured_parts(imu_topic("/a", kForce, kNone)), ImuParts::kForces);
  EXPECT_EQ(measured_parts(imu_topic("/a", Eigen::Vector3d::Constant(NAN), kRate)),
            ImuParts::kRates);
  EXPECT_EQ(measured_parts(imu_topic("/a", kNone, kNone)), ImuParts::kBoth);
  TopicContents stated = imu_topic("/a", kForce, kRate);
  stated.no_rate = true;
  EXPECT_EQ(measured_parts(stated), ImuParts::kBoth);
  EXPECT_EQ(stated_parts(stated), ImuParts::kForces);
  stated.no_force = true;  // a driver that knows no covariance
  EXPECT_EQ(stated_parts(stated), ImuParts::kBoth);
}

TEST(BagImu, TwoTopicsArePairedWhateverTheCalibrationNames) {
  for (const char* named : {"", "/d/gyro/sample", "d/accel/sample", "/imu0"}) {
    const ChosenTopics chosen = choose(kApart, named);
    EXPECT_EQ(name_of(chosen.accelerometer), "/d/accel/sample") << named;
    EXPECT_EQ(name_of(chosen.imu), "/d/gyro/sample");
    EXPECT_EQ(chosen.remarks.size(), std::string(named) == "/imu0" ? 1u : 0u);
  }
  std::vector<TopicContents> stated = kApart;
  stated[0].imu[1].angular_rate_imu = kRate;  // what the message states not to measure
  stated[0].no_rate = true;
  EXPECT_EQ(name_of(choose(stated).accelerometer), "/d/accel/sample");
}

TEST(BagImu, OfTwoDevicesTheNamesThatGoTogetherCount) {
  std::vector<TopicContents> topics = kApart;
  topics.push_back(imu_topic("/e/accel/sample", kForce, kNone));
  topics.push_back(imu_topic("/e/gyro/sample", kNone, kRate));
  const ChosenTopics chosen = choose(topics, "/e/gyro/sample");
  EXPECT_EQ(name_of(chosen.accelerometer), "/e/accel/sample");
  expect_parts(input_error([&] { choose(topics); }),
               {"expected one topic of sensor_msgs/Imu, or two", "[/ACCELEROMETER, /GYROSCOPE]"});
  const TopicContents sdk = imu_topic("/device_0/sensor_2/Accel_0/imu/data", kForce, kNone);
  const TopicContents one = imu_topic("/device_0/sensor_2/Gyro_0/imu/data", kNone, kRate);
  const TopicContents two = imu_topic("/device_1/sensor_2/Gyro_0/imu/data", kNone, kRate);
  EXPECT_EQ(partner_of(sdk, {&one, &two}), &one);
  EXPECT_EQ(partner_of(sdk, {}), nullptr);
}

TEST(BagImu, ATopicOfBothIsPreferred) {
  std::vector<TopicContents> topics = kApart;
  topics.push_back(imu_topic("/d/imu", kForce, kRate));
  for (const char* named : {"", "/d/imu", "/imu0"}) {
    const ChosenTopics chosen = choose(topics, named);
    EXPECT_EQ(name_of(chosen.imu), "/d/imu");
    EXPECT_EQ(chosen.accelerometer, nullptr);
  }
  topics.push_back(imu_topic("/other/imu", kForce, kRate));
  expect_parts(input_error([&] { choose(topics); }), {"expected one topic of sensor_msgs/Imu"});
}

TEST(BagImu, AFileMayNameBothInEitherOrder) {
  const fs::path folder = test::scratch();
  for (const char* list : {"[/d/accel/sample, /d/gyro/sample]", "[/d/gyro/sample, /d/accel/sample]",
                           "/d/gyro/sample", "[d/accel/sample]"}) {
    test::spill(folder / "topics.yaml", fmt::format("imu: {}\ncameras: [/cam]\n", list));
    const ChosenTopics chosen = choose(kApart, "", folder);
    EXPECT_EQ(name_of(chosen.accelerometer), "/d/accel/sample") << list;
    EXPECT_EQ(name_of(chosen.imu), "/d/gyro/sample");
  }
  test::spill(folder / "topics.yaml", "imu: [/d/accel/sample, /d/accel/sample]\ncameras: [/cam]\n");
  expect_parts(input_error([&] { choose(kApart, "", folder); }),
               {"an accelerometer and a gyroscope", "/d/accel/sample has accelerations alone"});
  test::spill(folder / "topics.yaml", "imu: []\ncameras: [/cam]\n");
  expect_parts(input_error([&] { choose(kApart, "", folder); }), {"one topic of an IMU, or two"});
}

TEST(BagImu, OneSensorAloneIsNamed) {
  expect_parts(input_error([&] {
                 choose({kApart[0], kApart[1]});
               }),
               {"/d/accel/sample has accelerations alone", "no other topic has angular rates"});
  expect_parts(input_error([&] {
                 choose({kApart[1], kApart[2]}, "/d/gyro/sample");
               }),
               {"/d/gyro/sample has angular rates alone", "no other topic has accelerations"});
}

TEST(BagImu, StaticTransformsTurnTheAccelerometer) {
  TopicContents accel = kApart[0], gyro = kApart[2];
  EXPECT_TRUE(split_extrinsics(accel, gyro, {}).remarks.empty()) << "both without a frame";
  accel.frame = "accel";
  gyro.frame = "gyro";
  expect_parts(split_extrinsics(accel, gyro, {}).remarks.at(0),
               {"no static transform", "'accel' of /d/accel/sample", "taken to be the same"});
  const Eigen::Matrix3d R = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()).matrix();
  BagContents contents;
  contents.transforms = {{.parent = "base", .child = "gyro", .parent_T_child = {}},
                         {.parent = "base", .child = "accel", .parent_T_child = {R, {0.01, 0, 0}}}};
  const SplitExtrinsics extrinsics = split_extrinsics(accel, gyro, contents);
  EXPECT_TRUE(extrinsics.gyro_T_accel.R.isApprox(R, 1e-12));
  expect_parts(extrinsics.remarks.at(0),
               {"by /tf_static", "turned by 90 deg", "10 mm", "gyroscope's axes"});
}

// As for cameras: what is mounted firmly may be published on /tf, and what moves does not count.
TEST(BagImu, ConstantTransformsOfTfTurnTheAccelerometerToo) {
  TopicContents accel = kApart[0], gyro = kApart[2];
  accel.frame = "accel";
  gyro.frame = "gyro";
  const Eigen::Matrix3d R = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()).matrix();
  const auto published = [&](double step) {
    MovingTransforms moving;
    for (int k = 0; k < 60; ++k) {
      moving.add({.parent = "base", .child = "gyro", .parent_T_child = {}});
      moving.add({.parent = "base",
                  .child = "accel",
                  .parent_T_child = {R, Eigen::Vector3d(0.01 + step * k, 0, 0)}});
    }
    BagContents contents;
    contents.moving = std::move(moving.all);
    return contents;
  };
  const SplitExtrinsics constant = split_extrinsics(accel, gyro, published(0));
  EXPECT_TRUE(constant.gyro_T_accel.R.isApprox(R, 1e-12));
  EXPECT_NEAR(constant.gyro_T_accel.p.x(), 0.01, 1e-12);
  ASSERT_EQ(constant.remarks.size(), 3u);
  expect_parts(constant.remarks[0], {"published 60 times", "constant", "taken from /tf"});
  expect_parts(constant.remarks[2], {"by /tf the accelerometer", "turned by 90 deg"});
  const SplitExtrinsics moving = split_extrinsics(accel, gyro, published(0.01));
  EXPECT_TRUE(moving.gyro_T_accel.R.isIdentity(0));
  expect_parts(moving.remarks.at(0), {"no static transform", "/tf leads there, but 'base' to",
                                      "moves by up to 0.59 m", "as no sensor does"});
}

/// A folder of MCAP files, one for each topic: the accelerometer at 100 Hz, the gyroscope at 200
/// Hz.
class BagOfTwoImuTopics : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = test::scratch();
    std::vector<std::string> accel, gyro, images;
    for (int k = 0; k < 40; ++k) {
      const Time time = kStamp + k * milliseconds(5);
      gyro.push_back(test::imu_message({.time = time, .angular_rate_imu = {0.01 * k, 1, 2}}));
      if (k % 2 == 0) {
        accel.push_back(test::imu_message(
            {.time = time + milliseconds(1), .specific_force_imu = {0.1, 0.02 * k, 9.5}}));
      }
    }
    for (int k = 0; k < 3; ++k) {
      images.push_back(
          test::image_message(kStamp + k * milliseconds(50), test::picture(50 + k), "mono8"));
    }
    test::spill(folder / "accel.mcap", test::mcap_of("/accel", "sensor_msgs/Imu", accel));
    test::spill(folder / "gyro.mcap", test::mcap_of("/gyro", "sensor_msgs/Imu", gyro));
    test::spill(folder / "cam.mcap", test::mcap_of("/cam0/image_raw", "sensor_msgs/Image", images));
    test::write_kalibr(folder);
  }
  fs::path folder;
};

TEST_F(BagOfTwoImuTopics, IsJoined) {
  const Recording r = read_recording(folder);
  ASSERT_EQ(r.imu.size(), 38u);  // from 5 to 190 ms: accelerometer from 1 to 191 ms
  for (const ImuSample& s : r.imu) {
    const double k = to_seconds(s.time - kStamp) / 0.005;
    EXPECT_LT((s.angular_rate_imu - Eigen::Vector3d(0.01 * k, 1, 2)).norm(), 1e-12);
    EXPECT_LT((s.specific_force_imu - Eigen::Vector3d(0.1, 0.02 * (k - 0.2), 9.5)).norm(), 1e-9);
  }
  std::string all;
  for (const std::string& remark : r.remarks) all += remark + "\n";
  expect_parts(all, {"accelerometer (/accel, 100 Hz) and the gyroscope (/gyro, 200 Hz)",
                     "38 samples at the gyroscope's times", "2 of 40 samples of the gyroscope",
                     "(1 before its first, 1 after its last"});
}

}  // namespace
}  // namespace chasles
