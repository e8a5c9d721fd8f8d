#pragma once

#include <array>

#include <geometry_msgs/msg/pose.hpp>

namespace geometry_msgs::msg {

struct PoseWithCovariance {
  Pose pose;
  std::array<double, 36> covariance{};
};

}  // namespace geometry_msgs::msg
