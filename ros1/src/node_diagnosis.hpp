#pragma once

#include "outgoing.hpp"
#include "robot_slam.hpp"

namespace chasles::ros1 {

/// What the node itself counts.
struct NodeCounts {
  int undecodable = 0;  ///< images
  int unset = 0;        ///< messages whose header.stamp is 0
};

/// The state of the estimator for /diagnostics. Error: lost. Warning: not started, degraded, or
/// since `before` no data came, or some were lost. The message is on the worst.
OutDiagnosis diagnosis_of(const app::RobotReport& now, const app::RobotReport& before,
                          const NodeCounts& counts, const NodeCounts& counts_before);

}  // namespace chasles::ros1
