#pragma once

#include "outgoing.hpp"
#include "robot_slam.hpp"

namespace chasles::ros1 {

/// What the node itself counts.
struct NodeCounts {
  int undecodable = 0;  ///< images
  int unset = 0;        ///< messages whose header.stamp is 0
};

/// app::diagnose() with what the node itself counts.
OutDiagnosis diagnosis_of(const app::RobotReport& now, const app::RobotReport& before,
                          const NodeCounts& counts, const NodeCounts& counts_before);

}  // namespace chasles::ros1
