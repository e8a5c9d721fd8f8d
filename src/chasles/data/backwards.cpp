#include <algorithm>
#include <utility>

#include <chasles/data/backwards.hpp>

namespace chasles {
namespace {

class Reversed : public ImageSource {
 public:
  Reversed(std::shared_ptr<const ImageSource> images, Time sum)
      : images_(std::move(images)), sum_(sum) {}

  std::size_t size() const override { return images_->size(); }
  Time time(std::size_t i) const override { return sum_ - images_->time(size() - 1 - i); }
  ImageFrame read(std::size_t i) const override {
    ImageFrame frame = images_->read(size() - 1 - i);
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
  if (r.imu_convention == ImuConvention::kIntervalMean) {
    // A sample holds from the one before to its own time; in reverse, from its own time on.
    for (std::size_t k = r.imu.size(); k-- > 1;) r.imu[k].time = r.imu[k - 1].time;
    if (!r.imu.empty()) r.imu.erase(r.imu.begin());
  }
  turn(r.imu, sum);
  for (ImuSample& sample : r.imu) sample.angular_rate_imu = -sample.angular_rate_imu;
}

}  // namespace

Recording backwards(Recording r) {
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
