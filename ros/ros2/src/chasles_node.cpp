#include <chrono>
#include <cmath>
#include <cstring>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <nav_msgs/msg/odometry.hpp>
#include <rclcpp/rclcpp.hpp>
#include <sensor_msgs/msg/compressed_image.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <tf2_msgs/msg/tf_message.hpp>

#include <chasles/base/error.hpp>
#include <chasles/codec/numbers.hpp>

#include "image_decoder.hpp"
#include "inertial_settings_io.hpp"
#include "robot_diagnosis.hpp"
#include "stamp_check.hpp"
#include "state_stream.hpp"

// Visual-inertial SLAM as a node of ROS 2: a thin layer over RobotSlam, as chasles_dds is.
namespace chasles::ros2 {
namespace {

using diagnostic_msgs::msg::DiagnosticArray;
using geometry_msgs::msg::TransformStamped;
using nav_msgs::msg::Odometry;
using sensor_msgs::msg::CompressedImage;
using sensor_msgs::msg::Image;
using sensor_msgs::msg::Imu;
using sensor_msgs::msg::PointCloud2;
using sensor_msgs::msg::PointField;
using tf2_msgs::msg::TFMessage;

using Texts = std::vector<std::string>;

Time time_of(const builtin_interfaces::msg::Time& stamp) {
  return std::chrono::seconds(stamp.sec) + std::chrono::nanoseconds(stamp.nanosec);
}

std_msgs::msg::Header header_of(const std::string& frame, Time time) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(time);
  std_msgs::msg::Header header;
  header.stamp.sec = static_cast<std::int32_t>(seconds.count());
  header.stamp.nanosec = static_cast<std::uint32_t>((time - seconds).count());
  header.frame_id = frame;
  return header;
}

template <typename Message>
void assign(const Eigen::Vector3d& v, Message& message) {
  message.x = v.x();
  message.y = v.y();
  message.z = v.z();
}

void assign(const Eigen::Matrix3d& R, geometry_msgs::msg::Quaternion& message) {
  const Eigen::Quaterniond q(R);
  message.x = q.x();
  message.y = q.y();
  message.z = q.z();
  message.w = q.w();
}

Eigen::Vector3d vector(const geometry_msgs::msg::Vector3& v) { return {v.x, v.y, v.z}; }

template <typename Row>
void assign(const Matrix6d& covariance, Row& row_by_row) {
  for (int i = 0; i < 36; ++i) row_by_row[static_cast<std::size_t>(i)] = covariance(i / 6, i % 6);
}

struct Frames {
  std::string map, odom, base;
};

/// The publishers of the node.
class Publications : public bridge::StateSink {
 public:
  Publications(rclcpp::Node& node, Frames frames)
      : frames_(std::move(frames)),
        odometry_(node.create_publisher<Odometry>("odometry", rclcpp::QoS(10))),
        points_(node.create_publisher<PointCloud2>("points", rclcpp::QoS(10))),
        diagnostics_(node.create_publisher<DiagnosticArray>("/diagnostics", rclcpp::QoS(10))),
        transforms_(node.create_publisher<TFMessage>("/tf", rclcpp::QoS(100))) {}

  void odometry(const BodyState& body, Time time) override {
    Odometry message;
    message.header = header_of(frames_.odom, time);
    message.child_frame_id = frames_.base;
    assign(body.world_T_body.p, message.pose.pose.position);
    assign(body.world_T_body.R, message.pose.pose.orientation);
    assign(body.pose_covariance, message.pose.covariance);
    assign(body.linear, message.twist.twist.linear);
    assign(body.angular, message.twist.twist.angular);
    assign(body.twist_covariance, message.twist.covariance);
    odometry_->publish(message);
    transform(frames_.odom, frames_.base, body.world_T_body, time);
  }

  void map_T_odom(const SE3& pose, Time time) override {
    transform(frames_.map, frames_.odom, pose, time);
  }

  void points(std::span<const MapLandmark> landmarks, Time time) override {
    PointCloud2 cloud;
    cloud.header = header_of(frames_.odom, time);
    cloud.height = 1;
    cloud.width = static_cast<std::uint32_t>(landmarks.size());
    for (const char* name : {"x", "y", "z", "sigma"}) {
      PointField field;
      field.name = name;
      field.offset = static_cast<std::uint32_t>(cloud.fields.size() * sizeof(float));
      field.datatype = PointField::FLOAT32;
      field.count = 1;
      cloud.fields.push_back(field);
    }
    cloud.point_step = static_cast<std::uint32_t>(cloud.fields.size() * sizeof(float));
    cloud.row_step = cloud.width * cloud.point_step;
    cloud.is_dense = true;
    cloud.data.resize(cloud.row_step);
    std::uint8_t* to = cloud.data.data();
    for (const MapLandmark& l : landmarks) {
      const Eigen::Vector4d values(l.p_world.x(), l.p_world.y(), l.p_world.z(),
                                   std::sqrt(l.covariance.trace()));
      const Eigen::Vector4f record = values.cast<float>();
      std::memcpy(to, record.data(), cloud.point_step);
      to += cloud.point_step;
    }
    points_->publish(cloud);
  }

  void diagnosis(const app::RobotDiagnosis& diagnosis, const rclcpp::Time& now) {
    DiagnosticArray message;
    message.header.stamp = now;
    message.status.resize(1);
    message.status[0].level = diagnosis.level;
    message.status[0].name = "chasles";
    message.status[0].message = diagnosis.message;
    for (const auto& [key, value] : diagnosis.values) {
      diagnostic_msgs::msg::KeyValue pair;
      pair.key = key;
      pair.value = value;
      message.status[0].values.push_back(pair);
    }
    diagnostics_->publish(message);
  }

 private:
  void transform(const std::string& parent, const std::string& child, const SE3& parent_T_child,
                 Time time) {
    TransformStamped transform;
    transform.header = header_of(parent, time);
    transform.child_frame_id = child;
    assign(parent_T_child.p, transform.transform.translation);
    assign(parent_T_child.R, transform.transform.rotation);
    TFMessage message;
    message.transforms.push_back(transform);
    transforms_->publish(message);
  }

  Frames frames_;
  rclcpp::Publisher<Odometry>::SharedPtr odometry_;
  rclcpp::Publisher<PointCloud2>::SharedPtr points_;
  rclcpp::Publisher<DiagnosticArray>::SharedPtr diagnostics_;
  rclcpp::Publisher<TFMessage>::SharedPtr transforms_;
};

/// The node. Parameters have the names and the meaning of chasles_dds's options.
class ChaslesNode : public rclcpp::Node {
 public:
  ChaslesNode()
      : rclcpp::Node("chasles"),
        calibration_(read_calibration()),
        publications_(*this, {.map = text("map_frame", "map"),
                              .odom = text("odom_frame", "odom"),
                              .base = text("base_frame", "base_link")}),
        stream_(stream_options(), publications_),
        slam_(setup(), {.on_estimates = [this](std::span<const Estimate> some,
                                               VisualInertialSlam& of) { stream_.take(some, of); },
                        .on_reset =
                            [this](const std::string& why) {
                              RCLCPP_WARN(get_logger(), "%s: the run begins anew", why.c_str());
                            },
                        .on_output =
                            [this](const std::string& sentence, bool written) {
                              if (written) {
                                RCLCPP_INFO(get_logger(), "%s", sentence.c_str());
                              } else {
                                RCLCPP_ERROR(get_logger(), "%s", sentence.c_str());
                              }
                            }}) {
    stream_.set_slam(slam_);
    subscribe();
    timer_ = create_wall_timer(std::chrono::seconds(1), [this] {
      const app::RobotReport report = slam_.report();
      publications_.diagnosis(app::diagnose(report, before_), now());
      before_ = report;
    });
  }

  /// Processes what waits, and writes the outputs. Then throws `before`, if that is an error.
  void finish(std::exception_ptr before) {
    slam_.finish();
    slam_.write_outputs(before);
  }

 private:
  std::string text(const std::string& name, const std::string& otherwise) {
    return declare_parameter<std::string>(name, otherwise);
  }

  SensorCalibration read_calibration() {
    const std::string path = text("calibration", "");
    if (path.empty()) {
      throw UsageError("the parameter calibration is missing, expected a file or folder");
    }
    return read_sensor_calibration(path);
  }

  bridge::StateStream::Options stream_options() {
    using Rate = bridge::StateStream::Rate;
    const std::string rate = text("rate", "images");
    if (rate != "images" && rate != "samples") {
      throw UsageError("rate: found '" + rate + "', expected images or samples");
    }
    return {.base_T_imu = base_T_imu(),
            .rate = rate == "samples" ? Rate::kSamples : Rate::kImages,
            .points_period = declare_parameter<double>("points_period", 1.0)};
  }

  SE3 base_T_imu() {
    const auto v = declare_parameter<std::vector<double>>("base_T_imu", {0, 0, 0, 0, 0, 0, 1});
    if (v.size() != 7) {
      throw UsageError("base_T_imu: expected seven numbers: x, y, z, qx, qy, qz, qw");
    }
    return {checked_quaternion("base_T_imu", {v[3], v[4], v[5], v[6]}), {v[0], v[1], v[2]}};
  }

  app::RobotSetup setup() {
    app::SettingSources sources;
    sources.sets = declare_parameter<Texts>("set", Texts{});
    sources.set_option = "the parameter set";
    sources.config = text("config", "");
    sources.estimator = estimator_choice(text("estimator", "filter"));
    app::RobotSetup setup;
    setup.calibration = calibration_;
    setup.settings = app::inertial_run_settings_from(sources);
    setup.map = text("map", "");
    setup.output = text("output", "");
    setup.save_map = text("save_map", "");
    setup.lossless = declare_parameter<bool>("lossless", false);
    return setup;
  }

  void subscribe() {
    imu_topic_ = text("imu", "");
    if (imu_topic_.empty()) imu_topic_ = calibration_.imu_topic;
    if (imu_topic_.empty()) imu_topic_ = "/imu0";
    accelerometer_topic_ = text("accelerometer", "");
    subscribe_to_imu();
    Texts topics;
    for (std::size_t c = 0; c < calibration_.cameras.size(); ++c) {
      const bool named =
          c < calibration_.camera_topics.size() && !calibration_.camera_topics[c].empty();
      topics.push_back(named ? calibration_.camera_topics[c]
                             : "/cam" + std::to_string(c) + "/image_raw");
    }
    topics = declare_parameter<Texts>("cameras", topics);
    if (topics.size() != calibration_.cameras.size()) {
      throw UsageError("cameras: expected one topic for each camera of the calibration");
    }
    topics_ = topics;
    image_stamps_.resize(topics.size());
    for (std::size_t c = 0; c < topics.size(); ++c) subscribe(c, topics[c]);
  }

  // One topic, or one of the gyroscope and one of the accelerometer.
  void subscribe_to_imu() {
    const bool apart = !accelerometer_topic_.empty();
    const auto quality = rclcpp::SensorDataQoS().keep_last(2000);
    imu_ = create_subscription<Imu>(imu_topic_, quality, [this, apart](const Imu& message) {
      if (apart) {
        take_rate(message);
      } else {
        take_sample(message);
      }
    });
    if (!apart) return;
    accelerometer_ = create_subscription<Imu>(accelerometer_topic_, quality,
                                              [this](const Imu& message) { take_force(message); });
  }

  void subscribe(std::size_t camera, const std::string& topic) {
    const Camera& calibrated = calibration_.cameras[camera];
    decoders_.emplace_back(ImageSize{.width = calibrated.width, .height = calibrated.height}, 0,
                           topic);
    if (topic.ends_with("/compressed")) {
      compressed_.push_back(create_subscription<CompressedImage>(
          topic, rclcpp::SensorDataQoS(), [this, camera](const CompressedImage& message) {
            take_image(camera, message.header, [&](bridge::ImageDecoder& decoder) {
              return decoder.decode(view(message.data));
            });
          }));
    } else {
      images_.push_back(create_subscription<Image>(
          topic, rclcpp::SensorDataQoS(), [this, camera](const Image& message) {
            take_image(camera, message.header, [&](bridge::ImageDecoder& decoder) {
              return decoder.decode({.height = message.height,
                                     .width = message.width,
                                     .encoding = message.encoding,
                                     .big_endian = message.is_bigendian != 0,
                                     .step = message.step,
                                     .data = view(message.data)});
            });
          }));
    }
  }

  static std::string_view view(const std::vector<std::uint8_t>& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }

  void take_sample(const Imu& message) {
    ImuSample sample;
    sample.time = time_of(message.header.stamp);
    if (!imu_stamps_.is_set(sample.time, imu_topic_)) return;
    sample.specific_force_imu = vector(message.linear_acceleration);
    sample.angular_rate_imu = vector(message.angular_velocity);
    slam_.add(sample);
    note_sample(sample.time);
  }

  void take_rate(const Imu& message) {
    const Time time = time_of(message.header.stamp);
    if (!imu_stamps_.is_set(time, imu_topic_)) return;
    const AxesSample rate{time, vector(message.angular_velocity)};
    for (const Time joined : slam_.add_rate(rate)) note_sample(joined);
  }

  void take_force(const Imu& message) {
    const Time time = time_of(message.header.stamp);
    if (!accelerometer_stamps_.is_set(time, accelerometer_topic_)) return;
    const AxesSample force{time, vector(message.linear_acceleration)};
    for (const Time joined : slam_.add_force(force)) note_sample(joined);
  }

  void note_sample(Time time) {
    if (last_sample_ && time > *last_sample_) {
      stream_.take_sample(time, to_seconds(time - *last_sample_));
    }
    last_sample_ = time;
  }

  template <typename Decode>
  void take_image(std::size_t camera, const std_msgs::msg::Header& header, const Decode& decode) {
    const auto arrived = app::RobotSlam::Clock::now();
    const Time time = time_of(header.stamp);
    if (!image_stamps_[camera].is_set(time, topics_[camera])) return;
    GrayImage image;
    try {
      image = decode(decoders_[camera]);
    } catch (const InputError& error) {  // counts as missing
      RCLCPP_WARN(get_logger(), "%s", error.what());
    }
    slam_.add(camera, time, std::move(image), arrived);
  }

  SensorCalibration calibration_;
  Publications publications_;
  bridge::StateStream stream_;
  app::RobotSlam slam_;
  app::RobotReport before_;  // of the last diagnosis
  std::string imu_topic_;
  std::string accelerometer_topic_;  // of its own; empty: none
  Texts topics_;                     // of the cameras
  bridge::StampCheck imu_stamps_, accelerometer_stamps_;
  std::vector<bridge::StampCheck> image_stamps_;
  std::vector<bridge::ImageDecoder> decoders_;
  std::optional<Time> last_sample_;
  rclcpp::Subscription<Imu>::SharedPtr imu_, accelerometer_;
  std::vector<rclcpp::Subscription<Image>::SharedPtr> images_;
  std::vector<rclcpp::Subscription<CompressedImage>::SharedPtr> compressed_;
  rclcpp::TimerBase::SharedPtr timer_;
};

}  // namespace
}  // namespace chasles::ros2

int main(int argc, char** argv) {
  int code = 0;
  try {
    rclcpp::init(argc, argv);
    const auto node = std::make_shared<chasles::ros2::ChaslesNode>();
    // Whatever ends it, what was estimated is written.
    const std::exception_ptr error = chasles::app::error_of([&] { rclcpp::spin(node); });
    node->finish(error);
  } catch (const chasles::Error& error) {
    RCLCPP_ERROR(rclcpp::get_logger("chasles"), "%s", error.what());
    code = static_cast<int>(error.code());
  } catch (const std::exception& error) {  // of rclcpp: a parameter's type, a topic's name
    RCLCPP_ERROR(rclcpp::get_logger("chasles"), "%s", error.what());
    code = 1;
  }
  rclcpp::shutdown();
  return code;
}
