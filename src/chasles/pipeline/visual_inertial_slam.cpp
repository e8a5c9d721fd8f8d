#include <utility>

#include <chasles/frontend/frontend_checks.hpp>
#include <chasles/pipeline/feature_feed.hpp>
#include <chasles/pipeline/recording_sensors.hpp>
#include <chasles/pipeline/visual_inertial_slam.hpp>

namespace chasles {
namespace {

// Maximum number of images that wait for samples, where later images do not show that none come.
constexpr std::size_t kMostWaiting = 64;

// As the estimator uses the samples.
StatePredictor predictor_for(const InertialSlamSettings& settings, const ImuNoise& noise,
                             ImuBuffer::Options imu) {
  imu.vibration_noise = settings.vibration_noise.value_or(0);
  return {scaled(noise, settings.imu_noise_scale.value_or(1)), imu};
}

}  // namespace

VisualInertialSlam::VisualInertialSlam(const std::vector<Camera>& cameras, const ImuNoise& noise,
                                       const InertialRunSettings& settings,
                                       const ImuBuffer::Options& imu, std::vector<GrayImage> masks,
                                       std::shared_ptr<const LandmarkMap> prior)
    : cameras_(cameras),
      tracker_(settings.frontend, cameras, imu, std::move(masks)),
      estimator_(make_estimator(
          for_images(settings, cameras.size(), noise),
          InertialSensors{
              .cameras = cameras, .noise = noise, .imu = imu, .pixel_sigma = kFrontendPixelSigma},
          std::nullopt, std::move(prior))),
      predictor_(predictor_for(for_images(settings, cameras.size(), noise).filter, noise, imu)),
      biases_(FeatureFeed::kLead, Eigen::Vector3d::Zero()) {}

std::vector<Estimate> VisualInertialSlam::process(const ImuSample& sample) {
  tracker_.process(sample);
  predictor_.add(sample);
  std::vector<Estimate> estimates = estimator_->process(sample);
  const bool finite = sample.specific_force_imu.allFinite() && sample.angular_rate_imu.allFinite();
  if (finite && (!last_sample_ || sample.time > *last_sample_)) last_sample_ = sample.time;
  take_covered(estimates);
  note(estimates);
  return estimates;
}

void VisualInertialSlam::note(const std::vector<Estimate>& estimates) {
  if (!estimates.empty()) predictor_.correct(estimates.back());
}

std::vector<Estimate> VisualInertialSlam::process(ImageFrame images) {
  check_frame(images, {}, std::nullopt, cameras_);
  waiting_.add(std::move(images));
  std::vector<Estimate> estimates;
  take_covered(estimates);
  note(estimates);
  return estimates;
}

std::vector<Estimate> VisualInertialSlam::finish(const StopRequest& stop) {
  std::vector<Estimate> estimates;
  while (auto images = waiting_.next()) {
    take(std::move(*images), estimates);
    if (stop && stop()) return estimates;
  }
  append(estimator_->finish(), estimates);
  note(estimates);
  return estimator_->smooths() ? estimator_->smooth(stop) : estimates;
}

// Without samples images do not wait for ever: those that are too far behind a later one are
// processed, and the session judges them.
void VisualInertialSlam::take_covered(std::vector<Estimate>& estimates) {
  const auto covered = [&](const ImageFrame& images) {
    return (last_sample_ && *last_sample_ >= images.time) || waiting_.size() > kMostWaiting ||
           waiting_.newest().time - images.time > InertialSession::kLongestGap;
  };
  while (auto images = waiting_.next(covered)) take(std::move(*images), estimates);
}

void VisualInertialSlam::take(ImageFrame images, std::vector<Estimate>& estimates) {
  const TrackedFrame tracked =
      tracker_.process(std::make_shared<const ImageFrame>(std::move(images)), biases_.front());
  report_ = tracked.report;
  if (on_frame_) on_frame_(tracked.frame);
  append(estimator_->process(tracked.frame), estimates);
  biases_.pop_front();
  biases_.push_back(estimator_->gyroscope_bias());
}

}  // namespace chasles
