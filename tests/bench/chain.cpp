#include "chain.hpp"

#include <algorithm>
#include <functional>
#include <optional>

#include <chasles/camera/rig_overlap.hpp>
#include <chasles/pipeline/feature_feed.hpp>
#include <chasles/pipeline/recording_sensors.hpp>

namespace chasles::bench {
namespace {

std::function<std::optional<SensorEvent>()> events(const Footage& m, std::size_t cameras,
                                                   EventStream& stream) {
  return [&m, cameras, &stream]() -> std::optional<SensorEvent> {
    while (auto event = stream.next()) {
      if (auto* sample = std::get_if<ImuSample>(&*event)) return *sample;
      if (const auto* due = std::get_if<ImagesDue>(&*event)) {
        ImageFrame frame = m.frames[due->index];
        frame.images.resize(cameras);
        return frame;
      }
    }
    return std::nullopt;
  };
}

}  // namespace

Footage footage_of(Recording recording) {
  Footage m{.recording = std::move(recording), .frames = {}};
  const ImageSource& images = *m.recording.images;
  for (std::size_t i = 0; i < images.size(); ++i) m.frames.push_back(images.read(i));
  return m;
}

std::vector<Cost> chain(const Footage& m, std::size_t cameras,
                        const InertialRunSettings& settings) {
  const std::vector<Camera> used(m.recording.cameras.begin(),
                                 m.recording.cameras.begin() + static_cast<long>(cameras));
  const ImuBuffer::Options imu{.convention = m.recording.imu_convention};
  const auto estimator =
      make_estimator(for_images(settings, cameras_in_stereo(used), *m.recording.imu_noise),
                     {.cameras = used,
                      .noise = *m.recording.imu_noise,
                      .imu = imu,
                      .pixel_sigma = kFrontendPixelSigma});
  EventStream stream(m.recording);
  FeatureFeed feed(events(m, cameras, stream), settings.frontend, used, imu, false);
  std::vector<Cost> costs;
  Cost cost;
  for (double before = cpu_ms();;) {
    const auto item = feed.next();
    const double tracked_at = cpu_ms();
    if (!item) return costs;
    cost.frontend += tracked_at - before;
    const bool running = estimator->started();
    if (const auto* sample = std::get_if<ImuSample>(&*item)) estimator->process(*sample);
    if (const auto* tracked = std::get_if<TrackedFrame>(&*item)) {
      cost.report = tracked->report;
      const auto estimates = estimator->process(tracked->frame);
      feed.note_bias(estimator->status().gyroscope_bias);
      if (!estimates.empty()) cost.estimate = estimates.back();
    }
    before = cpu_ms();
    cost.filter += before - tracked_at;
    if (!std::holds_alternative<TrackedFrame>(*item)) continue;
    if (running) costs.push_back(cost);
    cost = {};
  }
}

void keep_least(const std::vector<Cost>& more, std::vector<Cost>& least) {
  if (least.empty()) least = more;
  for (std::size_t i = 0; i < least.size(); ++i) {
    least[i].frontend = std::min(least[i].frontend, more[i].frontend);
    least[i].filter = std::min(least[i].filter, more[i].filter);
  }
}

}  // namespace chasles::bench
