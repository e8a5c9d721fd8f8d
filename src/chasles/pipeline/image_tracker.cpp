#include <utility>

#include <chasles/base/stopwatch.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/pipeline/image_tracker.hpp>

namespace chasles {
namespace {

// Rotation from the IMU axes at one time to those at a later one.
RotationPrior rotation_between(ImuBuffer& imu, Time from, Time to, const Eigen::Vector3d& bias) {
  const std::vector<ImuInterval> intervals = imu.between(from, to);
  RotationPrior prior;
  bool measured = !intervals.empty();
  for (const ImuInterval& interval : intervals) {
    measured = measured && interval.gyroscope_extra_density == 0;  // no gap, not saturated
    prior.now_R_last_imu =
        so3::exp(-(interval.angular_rate_imu - bias) * interval.tau) * prior.now_R_last_imu;
  }
  prior.now_R_last_imu = so3::normalized(prior.now_R_last_imu);
  if (!prior.now_R_last_imu.allFinite()) return {};  // impossible rates
  prior.trusted = measured;
  return prior;
}

}  // namespace

ImageTracker::ImageTracker(const FrontendSettings& settings, std::vector<Camera> cameras,
                           const ImuBuffer::Options& imu, std::vector<GrayImage> masks)
    : frontend_(settings, std::move(cameras), std::move(masks)), imu_(imu) {}

TrackedFrame ImageTracker::process(std::shared_ptr<const ImageFrame> shared,
                                   const Eigen::Vector3d& gyroscope_bias) {
  const ImageFrame& images = *shared;
  const Stopwatch watch;
  TrackedFrame result;
  result.frame.time = images.time;
  if (last_ && images.time <= *last_) return result;
  RotationPrior prior;
  if (last_) prior = rotation_between(imu_, *last_, images.time, gyroscope_bias);
  result.frame = frontend_.process(images, prior);
  result.frame.images = std::move(shared);
  last_ = result.frame.time;
  imu_.drop_before(*last_);
  result.report = frontend_.report();
  result.seconds = watch.seconds();
  return result;
}

}  // namespace chasles
