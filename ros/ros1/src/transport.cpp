#include "transport.hpp"

#include <atomic>
#include <csignal>
#include <deque>

#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <ros/spinner.h>
#include <std_srvs/Trigger.h>

#include "ros_messages.hpp"

// A RawMessage goes for a message of any type.
namespace ros {
namespace message_traits {

using chasles::ros1::RawMessage;

template <>
struct IsMessage<RawMessage> : TrueType {};
template <>
struct MD5Sum<RawMessage> {
  static const char* value() { return "*"; }
  static const char* value(const RawMessage&) { return value(); }
};
template <>
struct DataType<RawMessage> {
  static const char* value() { return "*"; }
  static const char* value(const RawMessage&) { return value(); }
};
template <>
struct Definition<RawMessage> {
  static const char* value() { return ""; }
  static const char* value(const RawMessage&) { return value(); }
};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<chasles::ros1::RawMessage> {
  template <typename Stream>
  static void read(Stream& stream, chasles::ros1::RawMessage& message) {
    const std::uint32_t size = stream.getLength();
    message.bytes.assign(reinterpret_cast<const char*>(stream.advance(size)), size);
  }
};

template <>
struct PreDeserialize<chasles::ros1::RawMessage> {
  static void notify(const PreDeserializeParams<chasles::ros1::RawMessage>& params) {
    const auto type = params.connection_header->find("type");
    if (type != params.connection_header->end()) params.message->type = type->second;
  }
};

}  // namespace serialization
}  // namespace ros

namespace chasles::ros1 {
namespace {

volatile std::sig_atomic_t stop_requested = 0;

void request_stop(int) { stop_requested = 1; }

/// A topic with a queue and a thread of its own.
struct Subscription {
  ros::CallbackQueue queue;
  ros::AsyncSpinner spinner{1, &queue};
  ros::Subscriber subscriber;
};

ros::NodeHandle connected(int& argc, char** argv, const std::string& name) {
  ros::init(argc, argv, name, ros::init_options::NoSigintHandler);
  struct sigaction action = {};
  action.sa_handler = request_stop;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  while (!ros::master::check()) {
    if (stop_requested != 0) throw std::runtime_error("stopped while there was no master");
    ROS_INFO_THROTTLE(5, "waiting for the master at %s", ros::master::getURI().c_str());
    ros::WallDuration(0.1).sleep();
  }
  return ros::NodeHandle("~");
}

}  // namespace

struct Transport::Parts {
  Parts(int argc, char** argv, const std::string& node) : own(connected(argc, argv, node)) {
    constexpr std::uint32_t kMany = 1000, kFew = 10;
    odometry = own.advertise<nav_msgs::Odometry>("odometry", kMany);
    frame_odometry = own.advertise<nav_msgs::Odometry>("frame_odometry", kMany);
    pose = own.advertise<geometry_msgs::PoseWithCovarianceStamped>("pose", kMany);
    pose_in_map = own.advertise<geometry_msgs::PoseWithCovarianceStamped>("pose_in_map", kMany);
    path = own.advertise<nav_msgs::Path>("path", kFew);
    points = own.advertise<sensor_msgs::PointCloud2>("points", kFew);
    tf = ros::NodeHandle().advertise<tf2_msgs::TFMessage>("/tf", kMany);
    diagnostics =
        ros::NodeHandle().advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", kFew);
  }

  ros::NodeHandle own;
  std::string name = ros::this_node::getName();
  ros::Publisher odometry, frame_odometry, pose, pose_in_map, path, points, tf, diagnostics;
  std::deque<ros::ServiceServer> services;
  std::deque<ros::WallTimer> timers;
  std::deque<Subscription> subscriptions;
  ros::AsyncSpinner spinner{1};  // of services and timers
};

Transport::Transport(int argc, char** argv, const std::string& name)
    : parts_(std::make_unique<Parts>(argc, argv, name)) {}

Transport::~Transport() {
  parts_.reset();
  ros::shutdown();
}

XmlRpc::XmlRpcValue Transport::parameters() const {
  XmlRpc::XmlRpcValue tree;
  ros::param::get(parts_->name, tree);
  return tree;
}

std::string Transport::resolved(const std::string& topic) const {
  return ros::NodeHandle().resolveName(topic);
}

const std::string& Transport::name() const { return parts_->name; }

void Transport::subscribe(const std::string& topic, std::uint32_t queue, Handler handler) {
  Subscription& subscription = parts_->subscriptions.emplace_back();
  ros::SubscribeOptions options = ros::SubscribeOptions::create<RawMessage>(
      topic, queue,
      [handler = std::move(handler)](const boost::shared_ptr<const RawMessage>& message) {
        handler(*message);
      },
      {}, &subscription.queue);
  options.transport_hints = ros::TransportHints().tcpNoDelay();
  subscription.subscriber = ros::NodeHandle().subscribe(options);
}

void Transport::serve(const std::string& name, Service service) {
  using Request = std_srvs::Trigger::Request;
  using Response = std_srvs::Trigger::Response;
  const boost::function<bool(Request&, Response&)> answer = [service = std::move(service)](
                                                                Request&, Response& response) {
    const auto [success, message] = service();
    response.success = success ? 1 : 0;
    response.message = message;
    return true;
  };
  parts_->services.push_back(parts_->own.advertiseService(name, answer));
}

void Transport::every(double seconds, std::function<void()> work) {
  parts_->timers.push_back(parts_->own.createWallTimer(
      ros::WallDuration(seconds),
      [work = std::move(work)](const ros::WallTimerEvent&) { work(); }));
}

void Transport::publish_odometry(const OutOdometry& odometry) {
  parts_->odometry.publish(message_of(odometry));
}
void Transport::publish_frame_odometry(const OutOdometry& odometry) {
  parts_->frame_odometry.publish(message_of(odometry));
}
void Transport::publish_pose(const OutPoseWithCovariance& pose) {
  parts_->pose.publish(message_of(pose));
}
void Transport::publish_pose_in_map(const OutPoseWithCovariance& pose) {
  parts_->pose_in_map.publish(message_of(pose));
}
void Transport::publish_path(const OutPath& path) { parts_->path.publish(message_of(path)); }
void Transport::publish_points(const OutPoints& points) {
  parts_->points.publish(message_of(points));
}
void Transport::publish_transforms(const std::vector<OutTransform>& transforms) {
  parts_->tf.publish(message_of(transforms));
}
void Transport::publish_diagnosis(const OutDiagnosis& diagnosis) {
  parts_->diagnostics.publish(message_of(diagnosis, parts_->name.substr(1), ros::Time::now()));
}
bool Transport::wants_path() const { return parts_->path.getNumSubscribers() > 0; }
bool Transport::wants_points() const { return parts_->points.getNumSubscribers() > 0; }

void Transport::log(LogLevel level, const std::string& text) const {
  switch (level) {
    case LogLevel::kInfo:
      ROS_INFO("%s", text.c_str());
      break;
    case LogLevel::kWarning:
      ROS_WARN("%s", text.c_str());
      break;
    case LogLevel::kError:
      ROS_ERROR("%s", text.c_str());
      break;
  }
}

void Transport::stop() { stop_requested = 1; }

void Transport::wait(bool drain) {
  parts_->spinner.start();
  for (Subscription& subscription : parts_->subscriptions) subscription.spinner.start();
  while (ros::ok() && stop_requested == 0) ros::WallDuration(0.02).sleep();
  for (Subscription& subscription : parts_->subscriptions) subscription.spinner.stop();
  if (drain) {
    for (Subscription& subscription : parts_->subscriptions) subscription.queue.callAvailable();
  }
  parts_->spinner.stop();
}

}  // namespace chasles::ros1
