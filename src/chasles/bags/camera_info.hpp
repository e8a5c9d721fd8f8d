#pragma once

#include <optional>
#include <string>
#include <vector>

#include <chasles/bags/ros_messages.hpp>
#include <chasles/camera/camera.hpp>

namespace chasles {

/// The camera of a sensor_msgs/CameraInfo, without extrinsics: K and D with a model of kLensModels
/// by any of its names (plumb_bob, rational_polynomial, equidistant, ...); of rectified images P
/// alone. Throws InputError, starting with `where`, for other lenses, for a camera that is not
/// calibrated, and for binning or a region of interest.
Camera camera_of(const RosCameraInfo& info, bool rectified, const std::string& where);

/// The motion to_T_from that a chain of static transforms gives, in either direction of each; none
/// if the frames are not connected.
std::optional<SE3> find_transform(const std::vector<RosTransform>& transforms,
                                  const std::string& to, const std::string& from);

/// The transforms of the shortest such chain, by their places in the list; none if the frames are
/// not connected.
std::optional<std::vector<std::size_t>> find_chain(const std::vector<RosTransform>& transforms,
                                                   const std::string& to, const std::string& from);

}  // namespace chasles
