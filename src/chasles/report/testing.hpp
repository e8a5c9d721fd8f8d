#pragma once

#include <cstdint>

#include <chasles/report/report.hpp>

namespace chasles::testing {

struct DriveOptions {
  int states = 1000;
  int landmarks = 5000;
  std::uint64_t seed = 1;
  bool truth = true;
  bool dead_reckoning = true;
};

/// A run to look at, without a filter: a 700 m loop through streets, an estimate whose error grows
/// as its covariance says, dead reckoning that bends away, landmarks on façades whose ellipses point
/// away from the cameras that saw them.
ReportRun synthetic_drive(const DriveOptions& options = {});

}  // namespace chasles::testing
