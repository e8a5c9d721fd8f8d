#include "options.hpp"

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>

#include <CLI/CLI.hpp>
#include <Eigen/Core>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/session/inertial_settings_io.hpp>

#include "network.hpp"

namespace chasles::bridge {
namespace {

void declare_input(CLI::App& parser, BridgeOptions& o) {
  parser
      .add_option("CALIBRATION", o.calibration,
                  "Kalibr's camera chain with imu.yaml beside it, the project's calibration.yaml, "
                  "or a folder with them or with EuRoC's mav0")
      ->required()
      ->type_name("");
  parser.add_option("--imu", o.imu, "Topic of sensor_msgs/msg/Imu")
      ->type_name("TOPIC")
      ->group("Input")
      ->default_str("that of the calibration, or /imu0");
  parser
      .add_option("--accelerometer", o.accelerometer,
                  "Topic of sensor_msgs/msg/Imu of the accelerometer, where it has one of its own, "
                  "along the axes of the gyroscope; --imu then is that of the gyroscope")
      ->type_name("TOPIC")
      ->group("Input");
  parser
      .add_option("--camera", o.cameras,
                  "Topic of sensor_msgs/msg/Image, or of CompressedImage where it ends with "
                  "/compressed; once for each camera of the calibration, in its order")
      ->type_name("TOPIC")
      ->group("Input")
      ->allow_extra_args(false)
      ->default_str("those of the calibration, or /cam0/image_raw, /cam1/image_raw");
  parser
      .add_option("--image-bits", o.image_bits,
                  "Bits in use, 8 to 16, of images with 16 (default 0: as the first image shows)")
      ->type_name("N")
      ->group("Input");
}

void declare_network(CLI::App& parser, BridgeOptions& o) {
  parser
      .add_option(
          "--domain", o.domain,
          fmt::format("Domain of DDS, 0 to {} (default: $ROS_DOMAIN_ID, or 0)", kLastDomain))
      ->type_name("N")
      ->group("Network");
  parser
      .add_option("--network", o.network,
                  "loopback (default): 127.0.0.1 alone; host: the processes of this machine, by "
                  "its own addresses; any, or the name or address of an interface: the network, "
                  "with multicast. Without this option $CYCLONEDDS_URI counts, where it is set. "
                  "Cyclone DDS receives on all addresses of the machine in all cases: a firewall "
                  "must guard its UDP ports, from 7410 + 250 DOMAIN on (docs/ros2.md)")
      ->type_name("NAME")
      ->group("Network");
  parser
      .add_flag("--reliable", o.reliable,
                "Ask for samples and images again that were lost; their publishers must be "
                "reliable. Default: best effort, which takes any publisher")
      ->group("Network");
}

void declare_method(CLI::App& parser, BridgeOptions& o) {
  const auto add = [&](const char* name, auto& value, const char* type, const char* text) {
    return parser.add_option(name, value, text)->type_name(type)->group("Method");
  };
  add("--set", o.settings.sets, "KEY=VALUE", "One setting; may be repeated, the last one counts")
      ->allow_extra_args(false);
  add("--config", o.settings.config, "FILE", "Settings from a YAML file, `key: value` a line");
  add("--chart", o.settings.chart, "NAME", "Error chart, as of chasles run");
  add("--estimator", o.estimator, "NAME", "filter (default) or window:N");
  add("--map", o.robot.map, "MAP", "Find the place in a map that an earlier run saved");
  add("--save-map", o.robot.save_map, "MAP", "Save a map at the end");
  add("--most-images", o.robot.most_images, "N",
      "Frames that may wait for the estimator; one more, and the oldest is dropped (default 3)");
  parser
      .add_flag("--lossless", o.robot.lossless,
                "Every image counts, however slow the estimator is: for recordings that are played")
      ->group("Method");
}

void declare_output(CLI::App& parser, BridgeOptions& o) {
  const auto add = [&](const char* name, auto& value, const char* type, const char* text) {
    return parser.add_option(name, value, text)->type_name(type)->group("Output");
  };
  add("--odometry", o.odometry, "TOPIC", "Topic of nav_msgs/msg/Odometry (default /odometry)");
  add("--px4", o.px4, "TOPIC",
      "The same as px4_msgs/msg/VehicleOdometry for PX4, on /fmu/in/vehicle_visual_odometry as a "
      "rule (default: none)");
  add("--rate", o.rate, "NAME",
      "Odometry and /tf at the rate of the images (default), or of the samples: predicted");
  parser.add_flag("!--no-tf", o.tf, "No transforms on /tf")->group("Output");
  add("--points", o.points, "TOPIC", "Topic of the map, sensor_msgs/msg/PointCloud2 (/points)");
  add("--points-period", o.points_period, "S", "Seconds between two maps; 0: none (default 1)");
  add("--diagnostics", o.diagnostics, "TOPIC", "Topic of the diagnostics (default /diagnostics)");
  add("--map-frame", o.map_frame, "FRAME", "Frame of a map of --map (default map)");
  add("--odom-frame", o.odom_frame, "FRAME", "Frame of the estimates (default odom)");
  add("--base-frame", o.base_frame, "FRAME", "Frame of the robot (default base_link)");
  add("--base-T-imu", o.base_T_imu_text, "X,Y,Z,QX,QY,QZ,QW",
      "Where the IMU is in the robot's frame [m] (default: it is that frame)");
  add("-o,--output", o.robot.output, "RUN", "Write the folder of chasles run -o at the end");
  add("--name", o.robot.name, "NAME", "Name of the run (default robot)");
  parser
      .add_option("--idle", o.idle,
                  "End after so many seconds without a message (default: on SIGINT)")
      ->type_name("S")
      ->group("Output");
  parser.add_flag("--quiet", o.quiet, "No log, only errors")->group("Output");
}

int domain_of_environment() {
  const char* text = std::getenv("ROS_DOMAIN_ID");
  if (text == nullptr || *text == '\0') return 0;
  const std::string_view view(text);
  int number = -1;
  const auto [end, error] = std::from_chars(view.data(), view.data() + view.size(), number);
  if (error == std::errc() && end == view.data() + view.size()) return number;
  throw UsageError(fmt::format("ROS_DOMAIN_ID: found '{}', expected a whole number from 0 to {}",
                               view, kLastDomain));
}

void check_range(const char* option, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw UsageError(
      fmt::format("{}: found {}, expected a number from {} to {}", option, value, low, high));
}

}  // namespace

void declare_bridge_options(CLI::App& parser, BridgeOptions& options) {
  declare_input(parser, options);
  declare_network(parser, options);
  declare_method(parser, options);
  declare_output(parser, options);
  parser.footer(filter_settings_help() + "\n" + inertial_run_settings_help());
}

BridgeNetwork network_of(const BridgeOptions& o) {
  BridgeNetwork network;
  network.domain = o.domain ? *o.domain : domain_of_environment();
  if (network.domain < 0 || network.domain > kLastDomain) {
    throw UsageError(fmt::format("{}: found {}, expected a domain from 0 to {}",
                                 o.domain ? "--domain" : "ROS_DOMAIN_ID", network.domain,
                                 kLastDomain));
  }
  const char* own = std::getenv("CYCLONEDDS_URI");
  if (o.network.empty() && own != nullptr && *own != '\0') return network;
  network.configuration = network_configuration(o.network.empty() ? "loopback" : o.network);
  return network;
}

SE3 base_T_imu_of(const BridgeOptions& o) {
  if (o.base_T_imu_text.empty()) return {};
  const std::string_view text = o.base_T_imu_text;
  Eigen::Matrix<double, 7, 1> v;
  const char *at = text.data(), *end = text.data() + text.size();
  int found = 0;
  while (found < 7) {
    const auto [next, error] = std::from_chars(at, end, v[found]);
    if (error != std::errc() || !std::isfinite(v[found])) break;
    ++found;
    at = next;
    if (found < 7 && (at == end || *at++ != ',')) break;
  }
  const std::string expected = fmt::format(
      "--base-T-imu: found '{}', expected seven numbers X,Y,Z,QX,QY,QZ,QW: metres and a unit "
      "quaternion",
      text);
  if (found < 7 || at != end) throw UsageError(expected);
  try {
    return {checked_quaternion("--base-T-imu", v.tail<4>()), v.head<3>()};
  } catch (const InputError&) {
    throw UsageError(expected);
  }
}

void check(const BridgeOptions& o) {
  if (o.rate != "images" && o.rate != "samples") {
    throw UsageError(fmt::format("--rate: found '{}', expected images or samples", o.rate));
  }
  if (o.image_bits != 0) check_range("--image-bits", o.image_bits, 8, 16);
  check_range("--most-images", o.robot.most_images, 1, 10'000);
  check_range("--points-period", o.points_period, 0, 1e6);
  if (o.idle) check_range("--idle", *o.idle, 0.1, 1e6);
  for (const auto& [option, frame] :
       {std::pair("--map-frame", &o.map_frame), std::pair("--odom-frame", &o.odom_frame),
        std::pair("--base-frame", &o.base_frame)}) {
    if (frame->empty()) throw UsageError(fmt::format("{}: expected a name", option));
  }
}

}  // namespace chasles::bridge
