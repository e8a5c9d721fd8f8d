#pragma once

#include <string>
#include <utility>

#include "intake.hpp"
#include "parameters.hpp"
#include "publisher.hpp"
#include "transport.hpp"

namespace chasles::ros1 {

/// Chasles as a node of ROS 1 (docs/ros.md).
class Node {
 public:
  /// Reads parameters, calibration and map, and subscribes. Throws UsageError or InputError.
  explicit Node(Transport& transport);

  /// Works until a signal or a shutdown; then processes what waits, and writes the run folder and
  /// the map that the parameters name. Throws as those do.
  void run();

 private:
  std::pair<bool, std::string> reset();
  std::pair<bool, std::string> save_map();
  void diagnose();
  OutDiagnosis diagnosis();

  Transport& transport_;
  NodeParameters parameters_;
  Publisher publisher_;
  Intake intake_;
  app::RobotReport before_;  // of the last diagnosis
  NodeCounts counts_before_;
};

}  // namespace chasles::ros1
