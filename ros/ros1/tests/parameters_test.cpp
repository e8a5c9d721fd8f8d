#include "parameters.hpp"

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>

#include "intake.hpp"

namespace chasles::ros1 {
namespace {

using XmlRpc::XmlRpcValue;

XmlRpcValue calibrated() {
  XmlRpcValue tree;
  tree["calibration"] = "folder";
  return tree;
}

template <typename Value>
XmlRpcValue with(const std::string& name, const Value& value) {
  XmlRpcValue tree = calibrated();
  tree[name] = value;
  return tree;
}

template <typename... Values>
XmlRpcValue list(const Values&... values) {
  XmlRpcValue all;
  all.setSize(sizeof...(values));
  int i = 0;
  ((all[i++] = values), ...);
  return all;
}

std::string usage_error(const XmlRpcValue& tree) {
  try {
    parameters_from(tree);
  } catch (const UsageError& error) {
    return error.what();
  }
  ADD_FAILURE() << "expected a UsageError, and there was none";
  return "";
}

void expect_in(const std::string& part, const std::string& text) {
  EXPECT_NE(text.find(part), std::string::npos) << "no '" << part << "' in: " << text;
}

TEST(Ros1Parameters, AreDefaultsWhereNoneIsSet) {
  const NodeParameters p = parameters_from(calibrated());
  EXPECT_EQ(p.calibration, "folder");
  EXPECT_EQ(p.odom_frame, "odom");
  EXPECT_EQ(p.robot.settings.filter.chart, InertialRunSettings{}.filter.chart);
  EXPECT_TRUE(p.robot.settings.estimator.is_filter());
  EXPECT_FALSE(p.base_T_imu);
  EXPECT_FALSE(p.robot.lossless);
}

TEST(Ros1Parameters, ReadsThoseOfTheNode) {
  XmlRpcValue tree = calibrated();
  tree["camera_topics"] = list("/a", "/b");
  tree["cameras"] = "mono";
  tree["lossless"] = true;
  tree["most_images"] = 7;
  tree["path_period"] = 2;  // YAML knows no difference
  tree["base_T_imu"] = list(1, 2.5, 3, 0, 0, 0, 1.0);
  tree["estimator"] = "window:5";
  tree["map_frame"] = "site";
  const NodeParameters p = parameters_from(tree);
  EXPECT_EQ(p.map_frame, "site");
  EXPECT_EQ(p.camera_topics, (std::vector<std::string>{"/a", "/b"}));
  EXPECT_EQ(p.cameras, 1u);
  EXPECT_TRUE(p.robot.lossless);
  EXPECT_EQ(p.robot.most_images, 7);
  EXPECT_EQ(p.path_period, 2);
  EXPECT_EQ(p.base_T_imu->p, Eigen::Vector3d(1, 2.5, 3));
  EXPECT_EQ(p.robot.settings.estimator.keyframes, 5);
}

TEST(Ros1Parameters, TheOthersAreSettings) {
  XmlRpcValue tree = calibrated();
  tree["chart"] = "standard";
  tree["start"]["heading"] = 0.1;
  tree["max_landmarks"] = 30;
  tree["calibrate_time_offset"] = false;
  const InertialRunSettings settings = parameters_from(tree).robot.settings;
  EXPECT_EQ(settings.filter.chart, "standard");
  EXPECT_EQ(settings.start.heading, 0.1);
  EXPECT_EQ(settings.filter.max_landmarks, 30);
  EXPECT_EQ(settings.filter.calibrate_time_offset, Calibrate::kFalse);
}

TEST(Ros1Parameters, OfWrongNamesTheNearestIsNamed) {
  expect_in("~chrat: unknown parameter; did you mean 'chart' or 'batch/chart'?",
            usage_error(with("chrat", "x")));
  expect_in("~imu_topics: unknown parameter; did you mean 'imu_topic'?",
            usage_error(with("imu_topics", "/imu")));
  XmlRpcValue group = calibrated();
  group["start"]["headin"] = 1;
  expect_in("~start/headin: unknown parameter; did you mean 'start/heading'?", usage_error(group));
}

TEST(Ros1Parameters, OfWrongValuesTheExpectedOneIsNamed) {
  expect_in("~calibration is missing", usage_error(XmlRpcValue()));
  expect_in("~calibration: found '7', expected a text", usage_error(with("calibration", 7)));
  expect_in("~lossless: found 'yes', expected true or false", usage_error(with("lossless", "yes")));
  expect_in("~cameras: found '2', expected mono or stereo", usage_error(with("cameras", 2)));
  expect_in("~most_images: found '0', expected a whole number from 1",
            usage_error(with("most_images", 0)));
  expect_in("~path_period: found '-1', expected seconds", usage_error(with("path_period", -1)));
  expect_in("~image_bits: found '7', expected 0, or 8 to 16", usage_error(with("image_bits", 7)));
  expect_in("~image_transport: found 'theora', expected raw or compressed",
            usage_error(with("image_transport", "theora")));
  expect_in("~camera_topics: found '/a', expected a list",
            usage_error(with("camera_topics", "/a")));
  expect_in("~base_T_imu: found '[1, 2, 3]', expected a list [x, y, z,",
            usage_error(with("base_T_imu", list(1, 2, 3))));
  expect_in("expected a list [x, y, z,",
            usage_error(with("base_T_imu", list(0, 0, 0, 0, 0, 0, 2))));
  expect_in("chart: found 'none', expected", usage_error(with("chart", "none")));
  expect_in("~estimator: found 'kalman', expected filter, batch or window:N",
            usage_error(with("estimator", "kalman")));
}

TEST(Ros1Parameters, TopicsAreThoseOfTheParametersThenOfTheCalibration) {
  SensorCalibration calibration;
  calibration.cameras.resize(2);
  calibration.camera_topics = {"/left", "/right"};
  calibration.imu_topic = "/imu";
  NodeParameters p;
  EXPECT_EQ(input_topics(p, calibration).cameras, calibration.camera_topics);
  EXPECT_EQ(input_topics(p, calibration).imu, "/imu");
  p.imu_topic = "/other";
  p.camera_topics = {"/a", "/b/compressed"};
  p.image_transport = "compressed";
  EXPECT_EQ(input_topics(p, calibration).imu, "/other");
  EXPECT_EQ(input_topics(p, calibration).cameras,
            (std::vector<std::string>{"/a/compressed", "/b/compressed"}));
}

TEST(Ros1Parameters, TopicsThatAreMissingAreErrors) {
  const auto error_of = [](const NodeParameters& p, const SensorCalibration& calibration) {
    try {
      input_topics(p, calibration);
    } catch (const UsageError& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  SensorCalibration calibration;
  calibration.cameras.resize(2);
  calibration.camera_topics.resize(2);
  expect_in("~imu_topic is missing", error_of({}, calibration));
  NodeParameters p;
  p.imu_topic = "/imu";
  expect_in(
      "~camera_topics has 0 topics, and the calibration does not name all (rostopic), "
      "expected 2",
      error_of(p, calibration));
  p.camera_topics = {"/a"};
  expect_in("~camera_topics has 1 topics, expected 2", error_of(p, calibration));
}

}  // namespace
}  // namespace chasles::ros1
