#pragma once

#include <optional>
#include <span>
#include <string>

#include <chasles/camera/image_frame.hpp>
#include <chasles/codec/image_decode.hpp>
#include <chasles/estimate/body_state.hpp>
#include <chasles/estimate/estimate.hpp>
#include <chasles/filter/past/history.hpp>
#include <chasles/slam/state_predictor.hpp>

#include "outgoing.hpp"
#include "raw_message.hpp"

// Between the messages of ROS 1 and the types of the libraries. Messages are decoded by the
// functions of the reader of bags, so that they mean the same.
namespace chasles::ros1 {

/// An image message's content as 8 bits of grey: sensor_msgs/Image in any encoding of
/// docs/formats.md, or sensor_msgs/CompressedImage. `bits`: in use, of 16-bit values. Throws
/// InputError, starting with `where`, for damage, another encoding, size or type.
GrayImage image_of(const RawMessage& message, const ImageSize& expected, int bits,
                   const std::string& where);
/// The bits in use by this image; 16 for one of 8 bits, for which they do not matter. Throws as
/// image_of().
int bits_of(const RawMessage& message, const ImageSize& expected, const std::string& where);

/// Throws InputError for a time before 1970 or after 2106, which a stamp of ROS cannot hold.
OutHeader header_of(Time time, const std::string& frame);
OutPose pose_of(const SE3& pose);
OutTransform transform_of(Time time, const std::string& parent, const std::string& child,
                          const SE3& parent_T_child);
/// `covariance` of [position; rotation], axes of the frame.
OutPoseWithCovariance pose_with_covariance_of(Time time, const std::string& frame, const SE3& pose,
                                              const Matrix6d& covariance);
OutOdometry odometry_of(Time time, const BodyState& body, const std::string& world_frame,
                        const std::string& body_frame);
OutPoints points_of(Time time, const std::string& frame, std::span<const MapLandmark> landmarks);

/// `rate_variance`: of the white noise of the angular rate, each axis [rad^2/s^2].
ImuMotion motion_of(const PredictedState& state, double rate_variance);
/// The pose of the body in the frame of the map, with the covariance of [position; rotation] there.
std::pair<SE3, Matrix6d> body_in_map(const PoseInMap& imu, const SE3& body_T_imu);

}  // namespace chasles::ros1
