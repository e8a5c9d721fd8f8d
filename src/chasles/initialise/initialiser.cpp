#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include <chasles/base/error.hpp>
#include <chasles/base/validate.hpp>
#include <chasles/initialise/dynamic_start.hpp>
#include <chasles/initialise/initialiser.hpp>
#include <chasles/initialise/static_conditions.hpp>
#include <chasles/initialise/static_start.hpp>

namespace chasles {
namespace {

constexpr double kLeastAccelerometerNoise = 1e-5;  // [m/s^2/sqrt(Hz)]
constexpr double kLeastGyroscopeNoise = 1e-6;      // [rad/s/sqrt(Hz)]

template <typename Value>
[[noreturn]] void reject(const std::string& what, Value found, const std::string& expected) {
  std::ostringstream text;
  text << "initialisation: " << what << " = " << found << ", expected " << expected;
  throw UsageError(text.str());
}

ImuNoise usable(ImuNoise noise) {
  const auto at_least = [](const char* name, double& density, double least) {
    if (!std::isfinite(density) || density < 0) reject(name, density, "a number not below 0");
    density = std::max(density, least);
  };
  at_least("accelerometer_noise_density", noise.accelerometer_noise_density,
           kLeastAccelerometerNoise);
  at_least("gyroscope_noise_density", noise.gyroscope_noise_density, kLeastGyroscopeNoise);
  return noise;
}

}  // namespace

Initialiser::Initialiser(const InitialiserSettings& settings, std::vector<Camera> cameras,
                         const ImuNoise& noise, const ImuBuffer::Options& imu, double pixel_sigma)
    : settings_(validated(settings)),
      cameras_(std::move(cameras)),
      noise_(usable(noise)),
      imu_options_(imu),
      pixel_sigma_(pixel_sigma),
      imu_(imu) {
  if (cameras_.empty()) reject("cameras", 0, "at least one");
  if (!std::isfinite(pixel_sigma) || pixel_sigma <= 0) {
    reject("pixel_sigma", pixel_sigma, "a positive number of pixels");
  }
}

void Initialiser::add(const ImuSample& sample) {
  const int gaps = imu_.counts().gaps;
  if (!imu_.add(sample)) return;
  if (imu_.counts().gaps > gaps) restart();
  samples_.push_back(sample);
}

void Initialiser::restart() {
  if (!window_.empty()) ++counts_.restarts;
  samples_.clear();
  window_.clear();
}

bool Initialiser::take(const FeatureFrame& frame) {
  const bool later = !last_frame_ || frame.time > *last_frame_;
  if (later) last_frame_ = frame.time;
  const Time reach = from_seconds(imu_options_.max_interval);
  if (!later || samples_.empty() || frame.time < samples_.front().time - reach ||
      frame.time > samples_.back().time + reach) {
    ++counts_.ignored_frames;
    return false;
  }
  window_.push_back(frame);
  while (window_.front().time < frame.time - from_seconds(settings_.max_window)) {
    window_.pop_front();
  }
  imu_.drop_before(window_.front().time);
  const Time static_from = frame.time - from_seconds(2 * settings_.static_window);
  while (samples_.size() > 1 && samples_.front().time < static_from) samples_.pop_front();
  return true;
}

std::optional<InertialStart> Initialiser::add(const FeatureFrame& frame) {
  if (!take(frame) || ++since_attempt_ < settings_.attempt_frames || window_.size() < 4) return {};
  since_attempt_ = 0;
  ++counts_.attempts;
  requirements_.clear();
  if (auto start = try_static()) return start;
  return try_dynamic();
}

void Initialiser::note(const char* way, std::vector<Requirement> requirements) {
  for (Requirement& r : requirements) {
    r.way = way;
    requirements_.push_back(std::move(r));
  }
}

std::optional<InertialStart> Initialiser::try_static() {
  const Time end = window_.back().time, from = end - from_seconds(settings_.static_window);
  std::vector<ImuSample> samples;
  for (const ImuSample& sample : samples_) {
    if (sample.time >= from && sample.time <= end) samples.push_back(sample);
  }
  std::vector<FeatureFrame> frames;
  for (const FeatureFrame& frame : window_) {
    if (frame.time >= from) frames.push_back(frame);
  }
  StandstillScratch scratch;
  const auto& requirements =
      static_conditions(samples, frames, cameras_.size(), noise_, pixel_sigma_, settings_, scratch);
  const bool is_static = all_met(requirements);
  note("static", requirements);
  if (!is_static) return std::nullopt;
  return static_start(end, standstill_means(samples, noise_), noise_, settings_);
}

std::vector<MeasuredReadout> Initialiser::readouts_of(const std::vector<FeatureFrame>& keyframes) {
  const Time readout = from_seconds(longest_readout(cameras_));
  std::vector<MeasuredReadout> readouts;
  for (const FeatureFrame& keyframe : keyframes) {
    if (readout <= Time{}) break;
    const auto intervals = imu_.between(keyframe.time, keyframe.time + readout);
    readouts.push_back(measured_readout(intervals, Vector6d::Zero()));
  }
  return readouts;
}

std::optional<InertialStart> Initialiser::try_dynamic() {
  std::vector<FeatureFrame> keyframes;
  for (const std::size_t i : choose_keyframes(window_.size(), settings_.keyframes)) {
    keyframes.push_back(window_[i]);
  }
  MotionWindow window =
      make_window(keyframes, cameras_, pixel_sigma_, settings_.max_tracks, readouts_of(keyframes));
  for (std::size_t k = 0; k + 1 < window.times.size(); ++k) {
    window.intervals.push_back(imu_.between(window.times[k], window.times[k + 1]));
  }
  StartAttempt attempt = dynamic_start(window, noise_, settings_);
  note("dynamic", std::move(attempt.requirements));
  return attempt.start;
}

std::vector<Requirement> Initialiser::requirements() const {
  if (!requirements_.empty()) return requirements_;
  return {at_least("frames with observations and IMU samples around them", since_attempt_,
                   settings_.attempt_frames, "")};
}

}  // namespace chasles
