#pragma once

#include <string>

namespace chasles::ros1 {

/// A message as its publisher serialised it, with the type that the publisher states, so that the
/// functions of the reader of bags decode it, and a topic may be of any type.
struct RawMessage {
  std::string type;  ///< "sensor_msgs/Imu"
  std::string bytes;
};

}  // namespace chasles::ros1
