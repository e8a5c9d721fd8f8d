#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include "outgoing.hpp"

// The messages of ROS 1 that the node publishes. C++17.
namespace chasles::ros1 {

nav_msgs::Odometry message_of(const OutOdometry& odometry);
geometry_msgs::PoseWithCovarianceStamped message_of(const OutPoseWithCovariance& pose);
nav_msgs::Path message_of(const OutPath& path);
/// Fields x, y, z, sigma, float32.
sensor_msgs::PointCloud2 message_of(const OutPoints& points);
tf2_msgs::TFMessage message_of(const std::vector<OutTransform>& transforms);
/// One status with this name.
diagnostic_msgs::DiagnosticArray message_of(const OutDiagnosis& diagnosis, const std::string& name,
                                            const ros::Time& now);

}  // namespace chasles::ros1
