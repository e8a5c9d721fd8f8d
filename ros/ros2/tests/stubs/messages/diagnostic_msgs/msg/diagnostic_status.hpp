#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <diagnostic_msgs/msg/key_value.hpp>

namespace diagnostic_msgs::msg {

struct DiagnosticStatus {
  std::uint8_t level = 0;
  std::string name, message, hardware_id;
  std::vector<KeyValue> values;
};

}  // namespace diagnostic_msgs::msg
