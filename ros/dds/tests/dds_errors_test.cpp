#include <thread>

#include <gtest/gtest.h>

#include "cdr.hpp"
#include "cli_test.hpp"
#include "network.hpp"
#include "process.hpp"
#include "robot_driver.hpp"

// What the bridge says of a command line, a calibration, messages and peers that it cannot use.
namespace chasles::test {
namespace {

using std::chrono::seconds;

constexpr int kErrorDomain = 82;

// Two pinholes of 80 x 60 pixels.
void write_calibration_files(const Scratch& folder) {
  std::string chain;
  for (int c = 0; c < 2; ++c) {
    chain +=
        "cam" + std::to_string(c) + ":\n  T_cam_imu: [[1, 0, 0, 0." + std::to_string(c) +
        "], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n  camera_model: pinhole\n"
        "  distortion_model: none\n  distortion_coeffs: []\n  intrinsics: [40, 40, 39.5, 29.5]\n"
        "  resolution: [80, 60]\n  rostopic: /cam" +
        std::to_string(c) + "/image_raw\n";
  }
  spill(folder / "camchain-imucam.yaml", chain);
  spill(folder / "imu.yaml",
        "accelerometer_noise_density: 0.01\naccelerometer_random_walk: 0.0002\n"
        "gyroscope_noise_density: 0.005\ngyroscope_random_walk: 4.0e-06\n");
}

Outcome dds(const Scratch& folder, const std::string& arguments, const std::string& before = "") {
  const std::string command = "cd '" + folder.string() + "' && " + before + " timeout 20 '" +
                              CHASLES_DDS_BINARY + "' " + arguments +
                              " >stdout.txt 2>stderr.txt </dev/null";
  const int status = std::system(command.c_str());
  return {.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1,
          .out = slurp(folder / "stdout.txt"),
          .err = slurp(folder / "stderr.txt")};
}

void expect_failure(const Outcome& outcome, int code, const std::vector<std::string>& parts) {
  EXPECT_EQ(outcome.code, code) << outcome.err;
  for (const std::string& part : parts) {
    EXPECT_NE(outcome.err.find(part), std::string::npos) << part << "\n" << outcome.err;
  }
}

TEST(DdsErrors, OfTheCommandLine) {
  const Scratch folder;
  write_calibration_files(folder);
  expect_failure(dds(folder, ""), 1, {"CALIBRATION is required", "--help"});
  expect_failure(dds(folder, ". --wrong"), 1, {"--wrong"});
  expect_failure(dds(folder, ". --domain 233"), 1, {"--domain: found 233", "0 to 232"});
  expect_failure(dds(folder, ".", "ROS_DOMAIN_ID=many"), 1, {"ROS_DOMAIN_ID: found 'many'"});
  expect_failure(dds(folder, ". --network 'a b'"), 1, {"--network: found 'a b'", "loopback"});
  expect_failure(dds(folder, ". --domain 82 --network nosuch0"), 1,
                 {"the domain 82 cannot be joined", "--network"});
  expect_failure(dds(folder, ". --camera /a"), 1, {"--camera: found 1 topics, expected 2"});
  expect_failure(dds(folder, ". --camera /a --camera /imu0"), 1, {"/imu0 is given twice"});
  expect_failure(dds(folder, ". --imu '/im u'"), 1, {"the topic '/im u'", "letters"});
  expect_failure(dds(folder, ". --base-T-imu 1,2,3,0,0,0,2"), 1,
                 {"--base-T-imu: found '1,2,3,0,0,0,2'", "unit quaternion"});
  expect_failure(dds(folder, ". --base-T-imu 1,2,3"), 1, {"seven numbers"});
  expect_failure(dds(folder, ". --rate 100"), 1, {"--rate: found '100'", "images or samples"});
  expect_failure(dds(folder, ". --image-bits 7"), 1, {"--image-bits: found 7", "8 to 16"});
  expect_failure(dds(folder, ". --odom-frame ''"), 1, {"--odom-frame: expected a name"});
  expect_failure(dds(folder, ". --set max_landmark=3"), 1, {"max_landmark"});
  expect_failure(dds(folder, ". --domain 82 --estimator batch"), 1, {"batch", "window:N"});
  expect_failure(dds(folder, ". --save-map nowhere/a.map"), 1, {"nowhere"});
  expect_failure(dds(folder, ". -o imu.yaml"), 1, {"imu.yaml"});
}

TEST(DdsErrors, OfTheCalibration) {
  const Scratch folder;
  write_calibration_files(folder);
  expect_failure(dds(folder, "nothing"), 2, {"nothing: there is no such file"});
  expect_failure(dds(folder, "imu.yaml"), 2, {"imu.yaml: has no camera"});
}

// Starts the bridge, sends one image to the first camera, and returns how it ends.
Outcome sent_image(const Scratch& folder, const std::string& topic, const std::string& type,
                   const std::string& bytes) {
  Process process({CHASLES_DDS_BINARY, folder.string(), "--domain", std::to_string(kErrorDomain),
                   "--camera", topic, "--camera", "/other"},
                  folder / "log.txt");
  FastClient client(kErrorDomain);
  FastWriter writer(client, {"rt" + topic, "sensor_msgs::msg::dds_::" + type}, {});
  // Discovery ends on either side at a time of its own, and the bridge subscribes as best effort.
  int code = -1;
  for (int i = 0; i < 200 && code < 0; ++i) {
    writer.write(bytes);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    code = process.wait(seconds(0));
  }
  return {.code = code, .out = {}, .err = slurp(folder / "log.txt")};
}

TEST(DdsErrors, OfTheFirstImage) {
  const Scratch folder;
  write_calibration_files(folder);
  const Time time = seconds(7);
  expect_failure(sent_image(folder, "/a", "Image_",
                            image_bytes(time, 40, 60, "mono8", std::string(2400, 'x'))),
                 2, {"cam0 (/a): is 40 x 60 pixels, expected 80 x 60 as in the calibration"});
  expect_failure(sent_image(folder, "/a", "Image_",
                            image_bytes(time, 80, 60, "infrared", std::string(4800, 'x'))),
                 2, {"the encoding is 'infrared'", "mono8"});
  expect_failure(sent_image(folder, "/a/compressed", "CompressedImage_",
                            compressed_bytes(time, "webp", "RIFF no image")),
                 2, {"cam0 (/a/compressed)", "PNG"});
}

// A bridge that is reliable, and drivers that are not: it says why it hears nothing.
TEST(DdsErrors, OfSilence) {
  const Scratch folder;
  write_calibration_files(folder);
  Process process(
      {CHASLES_DDS_BINARY, folder.string(), "--domain", std::to_string(kErrorDomain), "--reliable"},
      folder / "log.txt");
  FastClient client(kErrorDomain);
  const FastWriter writer(client, {"rt/imu0", "sensor_msgs::msg::dds_::Imu_"},
                          {.reliable = false, .depth = 1});
  std::this_thread::sleep_for(seconds(7));
  process.interrupt();
  const int code = process.wait(seconds(5));
  expect_failure(
      {.code = code, .out = {}, .err = slurp(folder / "log.txt")}, 3,
      {"no message on /imu0 (sensor_msgs/msg/Imu): 0 publishers are there, and 1 more that are not "
       "reliable",
       "no message on /cam1/image_raw (sensor_msgs/msg/Image): 0 publishers are there, check",
       "no estimate: no samples of the IMU come"});
}

// The idle time begins with the bridge.
TEST(DdsErrors, OfNothingAtAll) {
  const Scratch folder;
  write_calibration_files(folder);
  const Outcome outcome = dds(folder, ". --domain 82 --idle 0.5 --quiet");
  expect_failure(outcome, 3, {"no estimate: no samples of the IMU come"});
}

TEST(DdsNetwork, IsThisMachineAloneByDefault) {
  using bridge::network_configuration;
  const std::string loopback = network_configuration("loopback");
  EXPECT_NE(loopback.find("address=\"127.0.0.1\""), std::string::npos);
  EXPECT_NE(loopback.find("<AllowMulticast>false<"), std::string::npos);
  const std::string host = network_configuration("host");
  EXPECT_EQ(host.find("NetworkInterface"), std::string::npos);
  EXPECT_NE(host.find("<AllowMulticast>false<"), std::string::npos);
  EXPECT_EQ(network_configuration("any").find("AllowMulticast"), std::string::npos);
  EXPECT_NE(network_configuration("eth1").find("name=\"eth1\""), std::string::npos);
  EXPECT_NE(network_configuration("192.0.2.7").find("address=\"192.0.2.7\""), std::string::npos);
}

}  // namespace
}  // namespace chasles::test
