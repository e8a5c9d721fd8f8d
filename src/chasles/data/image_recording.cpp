#include <fmt/format.h>

#include <chasles/data/image_recording.hpp>
#include <chasles/data/time_order.hpp>
#include <chasles/error.hpp>

namespace chasles {

void tidy_samples(const std::filesystem::path& file, Recording& recording) {
  if (recording.imu.empty()) {
    throw InputError(fmt::format("{}: holds no sample, expected an IMU's", file.string()));
  }
  bring_into_order(recording.imu, "IMU samples", recording.remarks);
}

void remark_on_coverage(Recording& recording) {
  const std::size_t frames = recording.images->size();
  const Time begin = recording.imu.front().time, end = recording.imu.back().time;
  std::size_t outside = 0;
  for (std::size_t k = 0; k < frames; ++k) {
    const Time time = recording.images->time(k);
    outside += time < begin || time > end ? 1 : 0;
  }
  if (outside == 0) return;
  recording.remarks.push_back(fmt::format(
      "{} of {} frames are before the first IMU sample or after the last: kept", outside, frames));
}

}  // namespace chasles
