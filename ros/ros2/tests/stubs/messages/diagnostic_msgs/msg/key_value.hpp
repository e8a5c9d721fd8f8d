#pragma once

#include <string>

namespace diagnostic_msgs::msg {

struct KeyValue {
  std::string key, value;
};

}  // namespace diagnostic_msgs::msg
