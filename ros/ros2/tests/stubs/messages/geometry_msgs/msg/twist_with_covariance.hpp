#pragma once

#include <array>

#include <geometry_msgs/msg/twist.hpp>

namespace geometry_msgs::msg {

struct TwistWithCovariance {
  Twist twist;
  std::array<double, 36> covariance{};
};

}  // namespace geometry_msgs::msg
