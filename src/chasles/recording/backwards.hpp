#pragma once

#include <chasles/recording/recording.hpp>

namespace chasles {

/// The recording with its motion reversed in time. Time t becomes first + last - t. Velocities and
/// angular rates change their sign; specific forces do not, because accelerations are even in time.
/// A recording that ends at a standstill then starts at one.
Recording backwards(Recording recording);

}  // namespace chasles
