#include "topic_calibration.hpp"

#include <gtest/gtest.h>

#include <chasles/bags/bag_testing.hpp>
#include <chasles/recording/readers.hpp>

// Against the calibration of a bag that holds the same messages (tools/test-bags).
namespace chasles::ros1 {
namespace {

class TopicCalibrationTest : public ::testing::Test {
 protected:
  TopicCalibrationTest() {
    contents_ = scan_bags({test::written_bag("calibrated.bag")});
    for (const TopicContents& topic : contents_.topics) by_name_[topic.topic.name] = &topic;
  }

  const TopicContents& topic(const std::string& name) const { return *by_name_.at(name); }

  TopicCalibration made() const {
    SensorCalibration imu;
    imu.imu_noise.gyroscope_noise_density = 0.005;
    return {imu, "/imu0", {"/cam0/image_raw", "/cam1/image_raw/compressed"}};
  }

  BagContents contents_;
  std::map<std::string, const TopicContents*> by_name_;
};

TEST_F(TopicCalibrationTest, IsThatOfTheBag) {
  const auto folder = test::scratch();
  test::spill(folder / "imu.yaml", test::kKalibrImu);
  std::filesystem::copy_file(test::written_bag("calibrated.bag"), folder / "bag.bag");
  const Recording bag = read_recording(folder / "bag.bag");

  TopicCalibration topics = made();
  EXPECT_EQ(topics.info_topics(),
            (std::vector<std::string>{"/cam0/camera_info", "/cam1/camera_info"}));
  topics.set_imu_frame(topic("/imu0").frame);
  topics.set_image_frame(0, topic("/cam0/image_raw").frame);
  topics.set_image_frame(1, topic("/cam1/image_raw/compressed").frame);
  topics.set_info(0, *topic("/cam0/camera_info").info);
  topics.add_transforms(contents_.transforms);
  EXPECT_FALSE(topics.calibration());
  EXPECT_NE(topics.missing().find("/cam1/camera_info"), std::string::npos) << topics.missing();
  topics.set_info(1, *topic("/cam1/camera_info").info);
  const auto found = topics.calibration();
  ASSERT_TRUE(found) << topics.missing();
  ASSERT_EQ(found->cameras.size(), 2u);
  for (std::size_t c = 0; c < 2; ++c) {
    EXPECT_EQ(found->cameras[c].fx, bag.cameras[c].fx);
    EXPECT_EQ(found->cameras[c].cam_T_imu.R, bag.cameras[c].cam_T_imu.R);
    EXPECT_EQ(found->cameras[c].cam_T_imu.p, bag.cameras[c].cam_T_imu.p);
  }
  EXPECT_EQ(found->imu_noise.gyroscope_noise_density, 0.005);
  EXPECT_EQ(found->time_offsets, (std::vector<Time>{Time{}, Time{}}));
}

// As the reader of bags: the axes of the gyroscope, the place of the accelerometer.
TEST_F(TopicCalibrationTest, OfAnAccelerometerApartTakesItsPlaceAndAxes) {
  TopicCalibration topics({}, "/gyro", {"/cam0/image_raw"}, "/accel");
  topics.set_imu_frame(topic("/imu0").frame);
  topics.set_image_frame(0, topic("/cam0/image_raw").frame);
  topics.set_info(0, *topic("/cam0/camera_info").info);
  topics.add_transforms(contents_.transforms);
  EXPECT_FALSE(topics.calibration());
  EXPECT_EQ(topics.missing(), "no message with a frame_id has come on /accel");
  topics.set_accelerometer_frame("accel");
  Eigen::Matrix3d R;
  R << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Eigen::Vector3d p(0.01, 0.02, -0.03);
  topics.add_transforms({{topic("/imu0").frame, "accel", {R, p}}});
  const auto found = topics.calibration();
  ASSERT_TRUE(found) << topics.missing();
  EXPECT_TRUE(found->gyro_R_accel.isApprox(R, 1e-12));
  TopicCalibration united({}, "/imu0", {"/cam0/image_raw"});
  united.set_imu_frame(topic("/imu0").frame);
  united.set_image_frame(0, topic("/cam0/image_raw").frame);
  united.set_info(0, *topic("/cam0/camera_info").info);
  united.add_transforms(contents_.transforms);
  // A point at the accelerometer, seen by the camera.
  const Eigen::Vector3d expected = united.calibration()->cameras[0].cam_T_imu * p;
  EXPECT_TRUE(found->cameras[0].cam_T_imu.p.isApprox(expected, 1e-12));
  EXPECT_NE(found->remarks.back().find("turned by 90 deg"), std::string::npos);
}

TEST_F(TopicCalibrationTest, SaysWhatItWaitsFor) {
  TopicCalibration topics = made();
  EXPECT_FALSE(topics.calibration());
  EXPECT_EQ(topics.missing(), "no message with a frame_id has come on /cam0/image_raw");
  topics.set_image_frame(0, "cam0_optical");
  topics.set_image_frame(1, "cam1_optical");
  EXPECT_FALSE(topics.calibration());
  EXPECT_EQ(topics.missing(), "no message with a frame_id has come on /imu0");
  topics.set_imu_frame("imu_link");
  topics.set_info(0, *topic("/cam0/camera_info").info);
  topics.set_info(1, *topic("/cam1/camera_info").info);
  EXPECT_FALSE(topics.calibration());
  EXPECT_NE(topics.missing().find("static transforms (/tf_static) do not lead from 'imu_link'"),
            std::string::npos)
      << topics.missing();
}

}  // namespace
}  // namespace chasles::ros1
