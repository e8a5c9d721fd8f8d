#pragma once

#include <concepts>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <chasles/robot/robot_slam.hpp>

namespace chasles {

/// What diagnostic_msgs/DiagnosticStatus says of a run.
struct RobotDiagnosis {
  enum Level : std::uint8_t { kOk = 0, kWarning = 1, kError = 2 };  ///< as in the message
  Level level = kOk;
  std::string message = "ok";
  std::vector<std::pair<std::string, std::string>> values = {};

  /// The first sentence of the worst level stays.
  void add(bool applies, Level of, const std::string& sentence) {
    if (!applies || of <= level) return;
    level = of;
    message = sentence;
  }
  void value(const std::string& name, const std::string& of) { values.emplace_back(name, of); }
  void value(const std::string& name, double of);  ///< with the digits that it needs
  template <std::integral Count>
  void value(const std::string& name, Count of) {
    value(name, std::to_string(of));
  }
};

/// Error: lost. Warning: not started, degraded, or since `before` no data came, or some were lost.
/// The message is on the worst. Counts of `before` that are of another run do not count.
RobotDiagnosis diagnose(const RobotReport& now, const RobotReport& before);

}  // namespace chasles
