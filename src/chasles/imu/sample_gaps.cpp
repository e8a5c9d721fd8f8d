#include <chasles/imu/sample_gaps.hpp>

namespace chasles {

std::optional<SampleGaps::Gap> SampleGaps::add(const ImuSample& sample) {
  std::optional<Gap> last;
  for (const ImuSample& measured : screen_.add(sample)) {
    if (const auto gap = gaps_.add(measured.time)) last = gap;
  }
  return last;
}

}  // namespace chasles
