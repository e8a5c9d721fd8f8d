#include <chasles/estimate/slam_report.hpp>

namespace chasles {

void add(const ImuBuffer::Counts& more, ImuBuffer::Counts& sum) {
  sum.used += more.used;
  sum.not_finite += more.not_finite;
  sum.not_later += more.not_later;
  sum.zero += more.zero;
  sum.spikes += more.spikes;
  sum.frozen += more.frozen;
  sum.interpolated += more.interpolated;
  sum.gaps += more.gaps;
  sum.saturated += more.saturated;
  sum.extrapolated += more.extrapolated;
}

void SlamReport::merge(const SlamReport& later) {
  add(later.imu, imu);
  timed.used += later.timed.used;
  timed.rejected += later.timed.rejected;
  timed.late += later.timed.late;
  resets += later.resets;
  dropped_frames += later.dropped_frames;
  places.searches += later.places.searches;
  places.proposed += later.places.proposed;
  places.rejected += later.places.rejected;
  if (later.places.placed) places.placed = later.places.placed;
  closures.insert(closures.end(), later.closures.begin(), later.closures.end());
  recognised.insert(recognised.end(), later.recognised.begin(), later.recognised.end());
  known_as.insert(later.known_as.begin(), later.known_as.end());
}

}  // namespace chasles
