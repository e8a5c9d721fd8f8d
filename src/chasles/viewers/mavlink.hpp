#pragma once

#include <span>
#include <string>

#include <chasles/viewers/frd_odometry.hpp>

namespace chasles {

/// A telemetry log (.tlog) with a MAVLink 2 message ODOMETRY (331) for each state: the pose in
/// MAV_FRAME_LOCAL_FRD, velocities in MAV_FRAME_BODY_FRD. Covariances are the upper triangle by
/// rows; those of the rates are NaN, and the first element of the velocity's where it is not
/// known. `quality` is 100 for ok, 50 for degraded, -1 for lost, 0 where it is not known.
std::string mavlink_log(std::span<const FrdOdometry> states);

}  // namespace chasles
