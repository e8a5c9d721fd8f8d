#pragma once

#include <cstdint>

#include <chasles/estimate/body_state.hpp>
#include <chasles/estimate/health.hpp>

#include "messages.hpp"

namespace chasles::bridge {

/// How good the odometry is, as PX4 has it.
struct Px4Quality {
  std::uint8_t resets = 0;  ///< modulo 256
  std::int8_t percent = 0;  ///< 100 ok, 50 degraded, 0 not known
};
Px4Quality px4_quality(Health health, std::size_t jumps);

/// px4_msgs/msg/VehicleOdometry of a body with REP 103's axes (x forward, y left, z up) in a world
/// with z up. Axes of the message are forward, right, down, of the world and of the body; variances
/// of the attitude are about axes of the body. Times are microseconds.
VehicleOdometryMessage vehicle_odometry(const BodyState& body, Time time,
                                        const Px4Quality& quality);

}  // namespace chasles::bridge
