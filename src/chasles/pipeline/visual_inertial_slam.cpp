#include <utility>

#include <chasles/filter/error_chart.hpp>
#include <chasles/frontend/frontend_checks.hpp>
#include <chasles/pipeline/feature_feed.hpp>
#include <chasles/pipeline/visual_inertial_slam.hpp>

namespace chasles {
namespace {

// Images at most that wait for samples, where their times do not tell that none come.
constexpr std::size_t kMostWaiting = 64;

}  // namespace

InertialSlamSettings for_images(InertialSlamSettings settings, std::size_t cameras) {
  const bool can = settings.chart != kLeftSe3Chart.name;
  if (settings.keep_scale == KeepScale::kAuto && cameras == 1 && can)
    settings.keep_scale = KeepScale::kTrue;
  return settings;
}

VisualInertialSlam::VisualInertialSlam(const std::vector<Camera>& cameras, const ImuNoise& noise,
                                       const VisualInertialSettings& settings,
                                       const ImuBuffer::Options& imu, std::vector<GrayImage> masks)
    : cameras_(cameras),
      tracker_(settings.frontend, cameras, imu, std::move(masks)),
      session_(for_images(settings.filter, cameras.size()), settings.start,
               {.cameras = cameras,
                .noise = noise,
                .imu = imu,
                .pixel_sigma = settings.filter.pixel_sigma.value_or(kFrontendPixelSigma)}),
      biases_(FeatureFeed::kLead, Eigen::Vector3d::Zero()) {}

std::vector<InertialEstimate> VisualInertialSlam::process(const ImuSample& sample) {
  tracker_.process(sample);
  session_.process(sample);
  const bool finite = sample.specific_force_imu.allFinite() && sample.angular_rate_imu.allFinite();
  if (finite && (!last_sample_ || sample.time > *last_sample_)) last_sample_ = sample.time;
  std::vector<InertialEstimate> estimates;
  take_covered(estimates);
  return estimates;
}

std::vector<InertialEstimate> VisualInertialSlam::process(ImageFrame images) {
  check_frame(images, {}, std::nullopt, cameras_);
  waiting_.push_back(std::move(images));
  std::vector<InertialEstimate> estimates;
  take_covered(estimates);
  return estimates;
}

std::vector<InertialEstimate> VisualInertialSlam::finish() {
  std::vector<InertialEstimate> estimates;
  while (!waiting_.empty()) take_oldest(estimates);
  for (InertialEstimate& e : session_.finish()) estimates.push_back(std::move(e));
  return estimates;
}

bool VisualInertialSlam::covered(Time image) const {
  return last_sample_ && *last_sample_ >= image;
}

// Without samples images do not wait for ever: those that a later one leaves so far behind have
// their turn, and the session judges them.
void VisualInertialSlam::take_covered(std::vector<InertialEstimate>& estimates) {
  while (!waiting_.empty() &&
         (covered(waiting_.front().time) || waiting_.size() > kMostWaiting ||
          waiting_.back().time - waiting_.front().time > InertialSession::kLongestGap)) {
    take_oldest(estimates);
  }
}

void VisualInertialSlam::take_oldest(std::vector<InertialEstimate>& estimates) {
  const ImageFrame images = std::move(waiting_.front());
  waiting_.pop_front();
  const TrackedFrame tracked = tracker_.process(images, biases_.front());
  report_ = tracked.report;
  for (InertialEstimate& e : session_.process(tracked.frame)) estimates.push_back(std::move(e));
  biases_.pop_front();
  biases_.push_back(session_.gyroscope_bias());
}

}  // namespace chasles
