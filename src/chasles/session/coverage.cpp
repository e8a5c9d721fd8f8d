#include <algorithm>

#include <fmt/format.h>

#include <chasles/session/coverage.hpp>

namespace chasles {
namespace {

std::string cause_of(const FrameCoverage& coverage, const CoverageCauses& causes) {
  const std::size_t missing = coverage.frames - coverage.estimated;
  if (causes.start_seconds && 2 * coverage.before_start >= missing) {
    return fmt::format(": the start was found only after {:.1f} s", *causes.start_seconds);
  }
  if (causes.resets > 0) {
    return fmt::format(": the filter was lost and restarted {} times", causes.resets);
  }
  if (causes.dropped_frames > 0) {
    return fmt::format(": {} frames had no IMU samples or no usable time", causes.dropped_frames);
  }
  return {};
}

}  // namespace

double FrameCoverage::share() const {
  return frames == 0 ? 0 : static_cast<double>(estimated) / static_cast<double>(frames);
}

std::string coverage_remark(const FrameCoverage& coverage, const CoverageCauses& causes) {
  if (coverage.share() >= kLeastCoverage) return {};
  return fmt::format("estimated {} of {} frames{}", coverage.estimated, coverage.frames,
                     cause_of(coverage, causes));
}

}  // namespace chasles
