#pragma once

#include <chasles/data/recording.hpp>

namespace chasles {

/// The same recording as it would be if all motion ran backwards: times t become first + last - t,
/// velocities and angular rates change their sign, specific forces do not (accelerations are even
/// in time). A recording that ends at rest then begins so.
Recording backwards(Recording recording);

}  // namespace chasles
