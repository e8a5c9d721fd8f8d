#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "robot_slam.hpp"

namespace chasles::bridge {

/// What diagnostic_msgs/msg/DiagnosticStatus says of a run.
struct Diagnosis {
  enum Level : std::uint8_t { kOk = 0, kWarn = 1, kError = 2 };
  Level level = kOk;
  std::string message;
  std::vector<std::pair<std::string, std::string>> values;
};
Diagnosis diagnose(const app::RobotReport& report);

}  // namespace chasles::bridge
