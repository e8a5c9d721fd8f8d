#include <algorithm>

#include <chasles/pipeline/liveliest_part.hpp>
#include <chasles/recording/image_views.hpp>

namespace chasles {
namespace {

// Start of the window of this length with the most rotation by the gyroscope.
Time liveliest(const std::vector<ImuSample>& imu, Time from, Time to, Time length) {
  Time best = from;
  double sum = 0, most = -1;
  std::size_t first = 0;
  for (std::size_t k = 0; k < imu.size() && imu[k].time <= to; ++k) {
    if (imu[k].time < from) {
      first = k + 1;
      continue;
    }
    sum += imu[k].angular_rate_imu.squaredNorm();
    while (imu[k].time - imu[first].time > length) {
      sum -= imu[first++].angular_rate_imu.squaredNorm();
    }
    if (sum <= most) continue;
    most = sum;
    best = imu[first].time;
  }
  return best;
}

}  // namespace

std::shared_ptr<const ImageSource> liveliest_part(const Recording& recording, double seconds) {
  const ImageSource& all = *recording.images;
  if (all.size() == 0) return recording.images;
  const Time length = from_seconds(seconds), first = all.time(0), last = all.time(all.size() - 1);
  if (last - first <= length) return recording.images;
  const Time begin = std::min(liveliest(recording.imu, first, last, length), last - length);
  return part_of(recording.images, begin, begin + length, recording.cameras.size());
}

}  // namespace chasles
