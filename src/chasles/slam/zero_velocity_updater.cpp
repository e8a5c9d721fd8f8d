#include <chasles/slam/zero_velocity_updater.hpp>

namespace chasles {

ZeroVelocityUpdater::ZeroVelocityUpdater(const InertialSlamSettings& settings,
                                         const ImuNoise& noise, std::size_t cameras,
                                         double pixel_sigma) {
  if (settings.zupt_velocity_sigma > 0) standstill_.emplace(noise, cameras, pixel_sigma);
}

bool ZeroVelocityUpdater::update(SlamContext& x, const FeatureFrame& frame, Time since) {
  if (!standstill_) return false;
  if (!standstill_->detected(frame)) {
    clone_.reset();
    return false;
  }
  if (!clone_ || since <= Time{}) {
    clone_ = x.frame;
    x.keep_pose(frame.time);
    return false;
  }
  zero_velocity_measurements(x.state(), x.state().clone(*clone_), to_seconds(since),
                             x.settings.zupt_velocity_sigma, measurements_);
  if (!(x.filter.joint_normalised_square(measurements_) < x.gate_square(9))) return false;
  return !x.filter.update(measurements_).failed;
}

}  // namespace chasles
