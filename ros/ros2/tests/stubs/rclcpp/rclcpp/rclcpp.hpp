#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <builtin_interfaces/msg/time.hpp>

// What ros/ros2/src uses of rclcpp, declared: so that its source can be compiled, not run, where
// there is no rclcpp.
#define RCLCPP_INFO(logger, ...) ::rclcpp::log(logger, __VA_ARGS__)
#define RCLCPP_WARN(logger, ...) ::rclcpp::log(logger, __VA_ARGS__)
#define RCLCPP_ERROR(logger, ...) ::rclcpp::log(logger, __VA_ARGS__)

namespace rclcpp {

class Logger {};
Logger get_logger(const std::string& name);
__attribute__((format(printf, 2, 3))) void log(const Logger& logger, const char* format, ...);

class Time {
 public:
  operator builtin_interfaces::msg::Time() const;
};

class QoS {
 public:
  explicit QoS(std::size_t depth);
  QoS& keep_last(std::size_t depth);
};
class SensorDataQoS : public QoS {
 public:
  SensorDataQoS();
};

template <typename Message>
class Publisher {
 public:
  using SharedPtr = std::shared_ptr<Publisher<Message>>;
  void publish(const Message& message);
};
template <typename Message>
class Subscription {
 public:
  using SharedPtr = std::shared_ptr<Subscription<Message>>;
};
class TimerBase {
 public:
  using SharedPtr = std::shared_ptr<TimerBase>;
};

class Node {
 public:
  using SharedPtr = std::shared_ptr<Node>;
  explicit Node(const std::string& name);
  virtual ~Node();
  Logger get_logger() const;
  Time now() const;
  template <typename Parameter>
  Parameter declare_parameter(const std::string& name, const Parameter& otherwise);
  template <typename Message>
  typename Publisher<Message>::SharedPtr create_publisher(const std::string& topic, const QoS& qos);
  template <typename Message, typename Callback>
  typename Subscription<Message>::SharedPtr create_subscription(const std::string& topic,
                                                                const QoS& qos,
                                                                Callback&& callback) {
    const std::function<void(const Message&)> taken = std::forward<Callback>(callback);
    return subscribed<Message>(topic, qos, taken);
  }
  template <typename Period, typename Callback>
  TimerBase::SharedPtr create_wall_timer(Period period, Callback&& callback) {
    return timer(std::chrono::nanoseconds(period), std::forward<Callback>(callback));
  }

 private:
  template <typename Message>
  typename Subscription<Message>::SharedPtr subscribed(
      const std::string& topic, const QoS& qos, const std::function<void(const Message&)>& taken);
  TimerBase::SharedPtr timer(std::chrono::nanoseconds period,
                             const std::function<void()>& callback);
};

void init(int argc, char** argv);
void spin(const Node::SharedPtr& node);
bool shutdown();

}  // namespace rclcpp
