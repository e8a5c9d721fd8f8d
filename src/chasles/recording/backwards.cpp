#include <algorithm>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/recording/backwards.hpp>

namespace chasles {
namespace {

class Reversed : public ImageSource {
 public:
  Reversed(std::shared_ptr<const ImageSource> images, Time sum)
      : images_(std::move(images)), sum_(sum) {}

  std::size_t size() const override { return images_->size(); }
  Time time(std::size_t i) const override { return sum_ - images_->time(size() - 1 - i); }
  bool has_image(std::size_t i, std::size_t camera) const override {
    return images_->has_image(size() - 1 - i, camera);
  }
  ImageFrame read(std::size_t i) const override { return read_cameras(i, SIZE_MAX); }
  ImageFrame read_cameras(std::size_t i, std::size_t cameras) const override {
    ImageFrame frame = images_->read_cameras(size() - 1 - i, cameras);
    frame.time = time(i);
    return frame;
  }
  ImageFrame read_undamaged(std::size_t i, std::size_t cameras,
                            const OnDamage& damaged) const override {
    ImageFrame frame = images_->read_undamaged(size() - 1 - i, cameras, damaged);
    frame.time = time(i);
    return frame;
  }

 private:
  std::shared_ptr<const ImageSource> images_;
  Time sum_;
};

// The sum of the first and the last time of all.
Time first_plus_last(const Recording& r) {
  Time first = Time::max(), last = Time::min();
  const auto take = [&](Time time) {
    first = std::min(first, time);
    last = std::max(last, time);
  };
  const auto take_ends = [&](const auto& events) {
    if (events.empty()) return;
    take(events.front().time);
    take(events.back().time);
  };
  take_ends(r.velocities);
  take_ends(r.imu);
  take_ends(r.frames);
  take_ends(r.truth);
  if (r.images && r.images->size() > 0) {
    take(r.images->time(0));
    take(r.images->time(r.images->size() - 1));
  }
  return first == Time::max() ? Time(0) : first + last;
}

template <typename Events>
void turn(Events& events, Time sum) {
  std::reverse(events.begin(), events.end());
  for (auto& event : events) event.time = sum - event.time;
}

void turn_imu(Recording& r, Time sum) {
  if (!is_rate_of_instant(r.imu_convention) && !r.imu.empty()) {
    // A mean holds from the sample before to its own time; in reverse, from its own time on.
    const bool force_is_mean = !is_force_of_instant(r.imu_convention);
    for (std::size_t k = 0; k + 1 < r.imu.size(); ++k) {
      r.imu[k].angular_rate_imu = r.imu[k + 1].angular_rate_imu;
      if (force_is_mean) r.imu[k].specific_force_imu = r.imu[k + 1].specific_force_imu;
    }
    // The first mean in reverse has no sample before it, and no interval to hold over.
    if (force_is_mean) r.imu.pop_back();
  }
  turn(r.imu, sum);
  for (ImuSample& sample : r.imu) sample.angular_rate_imu = -sample.angular_rate_imu;
}

// In reverse its last line is the first, a readout after the image's time.
void reject_rolling(const Recording& r) {
  for (std::size_t i = 0; i < r.cameras.size(); ++i) {
    if (!r.cameras[i].shutter.is_rolling()) continue;
    throw UsageError(fmt::format(
        "backwards: cam{} of {} has a rolling shutter, with a readout_time of {:.1f} ms; expected "
        "global shutters, whose images are of one instant in either direction",
        i, r.name, 1e3 * r.cameras[i].shutter.readout));
  }
}

}  // namespace

Recording backwards(Recording r) {
  reject_rolling(r);
  const Time sum = first_plus_last(r);
  turn_imu(r, sum);
  turn(r.frames, sum);
  turn(r.truth, sum);
  turn(r.true_motion, sum);
  for (TrueMotion& motion : r.true_motion) {
    motion.v_world = -motion.v_world;
    motion.gyroscope_bias = -motion.gyroscope_bias;
  }
  turn(r.velocities, sum);
  for (BodyVelocity& velocity : r.velocities) {
    velocity.linear_imu = -velocity.linear_imu;
    velocity.angular_imu = -velocity.angular_imu;
  }
  if (r.images) r.images = std::make_shared<Reversed>(r.images, sum);
  r.remarks.push_back("played backwards");
  return r;
}

}  // namespace chasles
