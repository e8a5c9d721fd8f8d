#include <algorithm>
#include <functional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/constants.hpp>
#include <chasles/base/interruption.hpp>
#include <chasles/camera/rig_overlap.hpp>
#include <chasles/pipeline/measured_offset.hpp>
#include <chasles/pipeline/recording_sensors.hpp>
#include <chasles/session/check_trial.hpp>

namespace chasles {
namespace {

constexpr double kLeastShare = 0.5;     // of the frames with an estimate
constexpr double kMostDegraded = 0.1;   // of the estimates
constexpr std::size_t kFewFrames = 40;  // a start may need as many
constexpr Time kSlack = std::chrono::milliseconds(100);

struct TrialOutcome {
  std::size_t frames = 0, estimates = 0, degraded = 0;
  std::string why;  // there is no start

  double share() const { return static_cast<double>(estimates) / static_cast<double>(frames); }
  bool works() const {
    return share() >= kLeastShare &&
           static_cast<double>(degraded) <= kMostDegraded * static_cast<double>(estimates);
  }
};

// The part of the recording that the tracks of its first cameras cover.
Recording part_with(const Recording& recording, const std::vector<FeatureFrame>& frames,
                    std::size_t cameras) {
  Recording part;
  part.name = recording.name;
  part.cameras.assign(recording.cameras.begin(),
                      recording.cameras.begin() + static_cast<std::ptrdiff_t>(cameras));
  part.imu_convention = recording.imu_convention;
  part.imu_noise = recording.imu_noise;
  part.imu_range = recording.imu_range;
  part.single_pixel_sigma =
      recording.images ? recording.single_pixel_sigma : inertial_sensors(recording).pixel_sigma;
  for (const ImuSample& sample : recording.imu) {
    if (sample.time < frames.front().time - kSlack) continue;
    if (sample.time > frames.back().time + kSlack) break;
    part.imu.push_back(sample);
  }
  for (const FeatureFrame& frame : frames) {
    part.frames.push_back({.time = frame.time});
    std::ranges::copy_if(
        frame.pixels, std::back_inserter(part.frames.back().pixels),
        [&](const PixelObservation& o) { return static_cast<std::size_t>(o.camera) < cameras; });
  }
  return part;
}

// `settings`: with the time offset from which a run starts.
TrialOutcome run_filter(const Recording& part, bool images, InertialRunSettings settings) {
  settings.filter.exact_map = Toggle::kFalse;
  settings.filter.pixel_sigma = part.single_pixel_sigma;
  if (images) {
    settings = for_images(settings, cameras_in_stereo(part.cameras), part.imu_noise.value(),
                          part.exact_calibration);
  }
  const std::unique_ptr<Estimator> estimator = make_estimator(settings, part);
  TrialOutcome outcome{.frames = part.frames.size(), .why = {}};
  EventStream stream(part);
  const auto note = [&](const std::vector<Estimate>& estimates) {
    outcome.estimates += estimates.size();
    outcome.degraded += static_cast<std::size_t>(std::ranges::count_if(
        estimates, [](const Estimate& e) { return e.health != Health::kOk; }));
  };
  while (const auto event = stream.next()) {
    interruption_point();
    if (const auto* sample = std::get_if<ImuSample>(&*event)) note(estimator->process(*sample));
    if (const auto* frame = std::get_if<FeatureFrame>(&*event)) note(estimator->process(*frame));
  }
  note(estimator->finish());
  outcome.why = estimator->why_not_started();
  return outcome;
}

// What is often wrong with an IMU, and how it is undone.
struct Suspicion {
  std::string what;
  std::function<void(ImuSample&)> undo;
};

std::vector<Suspicion> suspicions() {
  std::vector<Suspicion> list{
      {"the sign of the accelerometer changed (at a standstill, with z up, it shows +9.81)",
       [](ImuSample& s) { s.specific_force_imu *= -1; }},
      {"the gyroscope's numbers taken as deg/s",
       [](ImuSample& s) { s.angular_rate_imu *= kRadians; }},
      {"the accelerometer's numbers taken as g",
       [](ImuSample& s) { s.specific_force_imu *= kStandardGravity; }},
      {"the sign of the gyroscope changed", [](ImuSample& s) { s.angular_rate_imu *= -1; }}};
  for (int axis = 0; axis < 3; ++axis) {
    const char name = "xyz"[axis];
    list.push_back({fmt::format("the {} axis of the accelerometer changed in sign", name),
                    [axis](ImuSample& s) { s.specific_force_imu[axis] *= -1; }});
    list.push_back({fmt::format("the {} axis of the gyroscope changed in sign", name),
                    [axis](ImuSample& s) { s.angular_rate_imu[axis] *= -1; }});
  }
  return list;
}

// A change with which the filter works, if there is one.
struct Cure {
  std::string change;
  std::size_t estimates = 0;

  bool empty() const { return change.empty(); }
  std::string text() const {
    return fmt::format("{}{}, it estimates {} of them", kCureBegins, change, estimates);
  }
};

// The first change with which the filter works. `alone`: the first camera.
Cure cure_of(const Recording& alone, std::size_t cameras, bool images,
             const InertialRunSettings& settings) {
  if (cameras > 1) {
    const TrialOutcome outcome = run_filter(alone, images, settings);
    if (outcome.works()) {
      return {"the first camera alone (--cameras mono: the extrinsics of the others do not fit)",
              outcome.estimates};
    }
  }
  for (const Suspicion& suspicion : suspicions()) {
    Recording changed = alone;
    std::ranges::for_each(changed.imu, suspicion.undo);
    const TrialOutcome outcome = run_filter(changed, images, settings);
    if (outcome.works()) return {suspicion.what, outcome.estimates};
  }
  return {};
}

std::string what_happens(const TrialOutcome& o) {
  if (o.share() >= kLeastShare) {
    return fmt::format(
        "the filter reports {} of its {} estimates as degraded in the part that was tracked",
        o.degraded, o.estimates);
  }
  return fmt::format("the filter estimates {} of the {} frames of the part that was tracked{}{}",
                     o.estimates, o.frames, o.why.empty() ? "" : ": ", o.why);
}

}  // namespace

void report_trial(const Recording& recording, const std::vector<FeatureFrame>& frames,
                  CheckReport& report) {
  if (recording.imu.empty() || recording.cameras.empty() || !recording.imu_noise) return;
  if (frames.size() < kFewFrames) {
    report.not_checked.push_back(
        fmt::format("a start of the filter: {} frames are too few", frames.size()));
    return;
  }
  const std::size_t cameras = std::min<std::size_t>(recording.cameras.size(), 2);
  Recording part = part_with(recording, frames, cameras);
  const bool images = recording.images != nullptr;
  InertialRunSettings settings;
  const auto fit =
      images ? fit_camera(part.frames, part.cameras, 0, gyroscope_rates(part.imu)) : std::nullopt;
  const auto evidence =
      fit ? evidence_of(*fit, part.cameras, part.imu, settings) : TracksEvidence{};
  start_from_measured(settings, evidence);
  mend(part, settings.filter, evidence);
  const TrialOutcome outcome = run_filter(part, images, settings);
  report.facts.push_back({"filter", "estimates", 100 * outcome.share(), "% of the frames"});
  if (outcome.works()) return;
  const Cure cure = cure_of(part_with(recording, frames, 1), cameras, images, settings);
  const bool few = outcome.share() < kLeastShare;
  report.findings.push_back(
      {.severity = !cure.empty() || outcome.estimates == 0 ? Severity::kError : Severity::kWarning,
       .about = "filter",
       .what = !cure.empty() ? fmt::format("the filter works only with {}; as recorded, {}",
                                           cure.change, what_happens(outcome))
                             : what_happens(outcome),
       .value = few ? 100 * outcome.share()
                    : 100.0 * static_cast<double>(outcome.degraded) /
                          static_cast<double>(outcome.estimates),
       .threshold = 100 * (few ? kLeastShare : kMostDegraded),
       .unit = "%",
       .advice = !cure.empty() ? cure.text()
                               : "see the other findings and docs/troubleshooting.md; a start "
                                 "needs a second of standstill, or of motion that accelerates"});
}

}  // namespace chasles
