#include <utility>

#include <chasles/base/overloaded.hpp>
#include <chasles/camera/rig_overlap.hpp>
#include <chasles/frontend/frontend_checks.hpp>
#include <chasles/pipeline/recording_sensors.hpp>
#include <chasles/pipeline/visual_inertial_slam.hpp>
#include <chasles/slam/imu_in_use.hpp>

namespace chasles {
namespace {

// As the estimator uses the samples.
StatePredictor predictor_for(const InertialSlamSettings& settings, const ImuNoise& noise,
                             const ImuBuffer::Options& imu) {
  return {noise_in_use(settings, noise), imu_in_use(settings, imu),
          StatePredictor::Work::kOnDemand};
}

ImuBuffer::Options behind_a_screen(ImuBuffer::Options imu) {
  imu.screened = true;
  return imu;
}

}  // namespace

VisualInertialSlam::VisualInertialSlam(const std::vector<Camera>& cameras, const ImuNoise& noise,
                                       const InertialRunSettings& settings,
                                       const ImuBuffer::Options& imu, std::vector<GrayImage> masks,
                                       std::shared_ptr<const LandmarkMap> prior)
    : cameras_(cameras),
      tracker_(settings.frontend, cameras, behind_a_screen(imu), std::move(masks)),
      estimator_(make_estimator(
          for_images(settings, cameras_in_stereo(cameras), noise),
          InertialSensors{
              .cameras = cameras, .noise = noise, .imu = imu, .pixel_sigma = kFrontendPixelSigma},
          std::nullopt, std::move(prior))),
      predictor_(predictor_for(for_images(settings, cameras_in_stereo(cameras), noise).filter,
                               noise, imu)) {}

std::vector<Estimate> VisualInertialSlam::process(const ImuSample& sample) {
  predictor_.add(sample);
  order_.add(sample);
  return take_due();
}

void VisualInertialSlam::note(const std::vector<Estimate>& estimates) {
  if (!estimates.empty()) predictor_.correct(estimates.back());
}

std::vector<Estimate> VisualInertialSlam::process(ImageFrame images) {
  check_frame(images, {}, std::nullopt, cameras_);
  order_.add(std::move(images));
  return take_due();
}

std::vector<Estimate> VisualInertialSlam::take_due() {
  std::vector<Estimate> estimates;
  while (auto event = order_.next()) take(std::move(*event), estimates);
  note(estimates);
  return estimates;
}

std::vector<Estimate> VisualInertialSlam::finish(const StopRequest& stop) {
  std::vector<Estimate> estimates;
  while (auto event = order_.next_at_end()) {
    const bool asks = is_frame(*event);
    take(std::move(*event), estimates);
    if (asks && stop && stop()) return estimates;
  }
  append(estimator_->finish(), estimates);
  note(estimates);
  return estimator_->status().smooths ? estimator_->complete(stop) : estimates;
}

void VisualInertialSlam::take(SensorEvent event, std::vector<Estimate>& estimates) {
  std::visit(
      Overloaded{[&](ImageFrame& images) { take(std::move(images), estimates); },
                 [&](auto& other) { append(estimator_->process(std::move(other)), estimates); }},
      event);
  for (const ImuSample& measured : estimator_->measured()) tracker_.process(measured);
}

void VisualInertialSlam::take(ImageFrame images, std::vector<Estimate>& estimates) {
  const TrackedFrame tracked =
      tracker_.process(std::make_shared<const ImageFrame>(std::move(images)), biases_.next());
  report_ = tracked.report;
  if (on_frame_) on_frame_(tracked.frame);
  append(estimator_->process(tracked.frame), estimates);
  biases_.pass();
  biases_.note(estimator_->status().gyroscope_bias);
}

}  // namespace chasles
