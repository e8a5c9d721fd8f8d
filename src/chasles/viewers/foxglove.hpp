#pragma once

#include <string>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include <chasles/base/time.hpp>
#include <chasles/lie/se3.hpp>
#include <chasles/viewers/protobuf.hpp>

namespace chasles {

/// The message types of Foxglove and Rerun that are used here, with the names and numbers of
/// foxglove/schemas 2.1.
const ProtoSchemas& foxglove_schemas();

// Values for proto_bytes().
nlohmann::json proto_time(Time time);                     ///< google.protobuf.Timestamp
nlohmann::json proto_vector(const Eigen::Vector3d& v);    ///< foxglove.Vector3, foxglove.Point3
nlohmann::json proto_rotation(const Eigen::Matrix3d& R);  ///< foxglove.Quaternion
nlohmann::json proto_pose(const SE3& pose);               ///< foxglove.Pose
/// foxglove.FrameTransform of parent_T_child.
nlohmann::json proto_transform(Time time, const std::string& parent, const std::string& child,
                               const SE3& pose);
nlohmann::json proto_colour(unsigned rgb, double opacity);  ///< foxglove.Color of 0xRRGGBB

}  // namespace chasles
