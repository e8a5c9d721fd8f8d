#include <chasles/imu/sample_gaps.hpp>

namespace chasles {

std::optional<SampleGaps::Gap> SampleGaps::add(const ImuSample& sample) {
  std::optional<Gap> gap;
  for (const ImuSample& measured : screen_.add(sample)) {
    if (last_ && measured.time <= *last_) continue;
    if (last_ && measured.time - *last_ > kLongest) gap = {.last = *last_, .next = measured.time};
    last_ = measured.time;
  }
  return gap;
}

}  // namespace chasles
