#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <chasles/calibration/imu_range.hpp>
#include <chasles/check/camera_clock.hpp>
#include <chasles/check/check.hpp>
#include <chasles/check/check_calibration.hpp>
#include <chasles/check/check_exposure.hpp>
#include <chasles/check/check_imu.hpp>
#include <chasles/check/check_times.hpp>
#include <chasles/check/check_truth.hpp>
#include <chasles/check/velocity_clock.hpp>
#include <chasles/recording/apply_calibration.hpp>
#include <chasles/velocity/level_axes.hpp>

namespace chasles {
namespace {

constexpr TimesLimits kSamples{.interval = 0.05}, kVelocities{.interval = 0.5},
    kFrames{.interval = 0.5};
constexpr double kSamplesAFrame = 2.5;
constexpr double kRate = 100;           // of an IMU [Hz]
constexpr double kLeastRate = 22;       // at 20 Hz each interval counts as a gap (ImuBuffer) [Hz]
constexpr double kSlowestRates = 0.05;  // [s]
constexpr std::size_t kImages = 50;     // pairs of frames to decode

template <typename Rows>
std::vector<Time> times_of(const Rows& rows) {
  std::vector<Time> times;
  for (const auto& row : rows) times.push_back(row.time);
  return times;
}

std::vector<Time> times_of_frames(const Recording& r) {
  std::vector<Time> times = times_of(r.frames);
  for (std::size_t i = 0; r.images && i < r.images->size(); ++i) {
    times.push_back(r.images->time(i));
  }
  return times;
}

std::vector<StampedRate> rates_of(const Recording& r) {
  std::vector<StampedRate> rates = gyroscope_rates(r.imu);
  if (!rates.empty()) return rates;
  for (const BodyVelocity& v : r.velocities) rates.push_back({v.time, v.angular_imu});
  return rates;
}

// The left camera of a rectified pair and its pixels.
Camera left_camera(const StereoRig& rig) {
  return {.width = 0,
          .height = 0,
          .fx = rig.fx,
          .fy = rig.fy,
          .cx = rig.cx,
          .cy = rig.cy,
          .distortion = Distortion::kNone,
          .cam_T_imu = rig.cam0_T_imu};
}

std::vector<FeatureFrame> left_frames(const std::vector<FeatureFrame>& frames) {
  std::vector<FeatureFrame> left;
  for (const FeatureFrame& frame : frames) {
    left.push_back({.time = frame.time});
    for (const StereoObservation& o : frame.observations) {
      left.back().pixels.push_back(
          {.landmark = o.landmark, .camera = 0, .pixel = o.pixels.head<2>()});
    }
  }
  return left;
}

// `interval`: between two frames [s].
void check_rate(const TimesCheck& imu, double interval, CheckReport& report) {
  const std::string advice = fmt::format(
      "record the IMU at {:.0f} Hz or more: the motion between samples is interpolated", kRate);
  if (imu.interval <= 0 || imu.interval > 1 / kLeastRate) {
    const double rate = imu.interval > 0 ? 1 / imu.interval : 0;
    report.findings.push_back(
        {.severity = Severity::kError,
         .about = "imu",
         .what = fmt::format("the IMU is too slow: {:.3g} samples a second", rate),
         .value = rate,
         .threshold = kLeastRate,
         .unit = "Hz",
         .advice = advice});
    return;
  }
  if (interval <= 0 || interval / imu.interval >= kSamplesAFrame) return;
  const double samples = interval / imu.interval;
  report.findings.push_back({.severity = Severity::kWarning,
                             .about = "imu",
                             .what = fmt::format("there are {:.1f} samples a frame", samples),
                             .value = samples,
                             .threshold = kSamplesAFrame,
                             .unit = "samples",
                             .advice = advice});
}

void check_streams(const Recording& r, CheckReport& report) {
  const TimesCheck imu = check_times(times_of(r.imu)), frames = check_times(times_of_frames(r));
  if (!r.imu.empty()) report_times(imu, kSamples, "imu", report);
  if (!r.velocities.empty()) {
    report_times(check_times(times_of(r.velocities)), kVelocities, "velocities", report);
  }
  report_times(frames, kFrames, r.images ? "images" : "frames", report);
  if (!r.imu.empty()) check_rate(imu, frames.interval, report);
}

void check_axes(const Recording& r, CheckReport& report) {
  const std::optional<LevelEvidence> evidence = level_evidence(r.velocities);
  if (!evidence || !evidence->level()) return;
  report.findings.push_back(
      {.severity = Severity::kNote,
       .about = "velocities",
       .what = fmt::format("they are along level axes, not the IMU's: their slope is {:.2f} +- "
                           "{:.2f} of that of the pitch from the rates",
                           evidence->slope, evidence->sigma),
       .value = evidence->slope,
       .threshold = LevelEvidence::kLeastSlope,
       .unit = "",
       .advice = "a run in mode slam treats them so, and estimates the vertical "
                 "(velocity_axes)"});
}

void check_velocity_clock(const Recording& r, CheckReport& report) {
  if (r.velocities.empty()) return;
  const std::optional<VelocityClock> clock = velocity_clock(r);
  if (!clock || !clock->is_determined()) {
    report.not_checked.push_back(
        clock ? "the clock of the velocities against the frames: their noise hides it"
              : "the clock of the velocities against the frames: too few seconds of tracks of a "
                "rectified pair, or too steady a motion");
    return;
  }
  report.facts.push_back({"velocities", "offset of their clock", 1e3 * clock->offset, "ms"});
  if (!clock->stands_out()) return;
  report.findings.push_back(
      {.severity = Severity::kWarning,
       .about = "velocities",
       .what = fmt::format("they are stamped {} by {:.0f} +- {:.0f} ms against the frames",
                           clock->offset > 0 ? "late" : "early", 1e3 * std::abs(clock->offset),
                           1e3 * clock->sigma),
       .value = 1e3 * std::abs(clock->offset),
       .threshold = 1e3 * VelocityClock::kLeastOffset,
       .unit = "ms",
       .advice = fmt::format("a run corrects the stamps with --set time_offset={:.3f}, or auto",
                             clock->offset)});
}

// Reports frames before the first sample and after the last.
void check_coverage(const Recording& r, CheckReport& report) {
  const std::vector<StampedRate> rates = rates_of(r);
  if (rates.empty()) return;
  const std::vector<Time> frames = times_of_frames(r);
  const auto outside = std::count_if(frames.begin(), frames.end(), [&](Time time) {
    return time < rates.front().time || time > rates.back().time;
  });
  // One at either end is normal.
  if (outside <= 2) return;
  report.findings.push_back(
      {.severity = Severity::kWarning,
       .about = r.images ? "images" : "frames",
       .what = fmt::format("{} of {} are before the first sample of the IMU or after the last",
                           outside, frames.size()),
       .value = static_cast<double>(outside),
       .threshold = 2,
       .unit = "frames",
       .advice = "check the two clocks, or cut the recording (--start, --stop)"});
}

// The reason why the rotation of a camera cannot be compared with the gyroscope.
std::string hindrance(const std::vector<FeatureFrame>& frames,
                      const std::vector<StampedRate>& rates) {
  const double interval = check_times(times_of(rates)).interval;
  if (frames.empty()) return "that needs tracks, and the recording has none";
  if (interval > kSlowestRates) {
    return fmt::format("the angular rates come at {:.0f} Hz, and {:.0f} Hz are needed",
                       1 / interval, 1 / kSlowestRates);
  }
  return "";
}

void check_turning(const Recording& r, const std::vector<Camera>& cameras,
                   const std::vector<FeatureFrame>& frames, CheckReport& report) {
  const std::vector<StampedRate> rates = rates_of(r);
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const std::string about = fmt::format("cam{}", c);
    std::string why_not = hindrance(frames, rates);
    if (why_not.empty()) {
      const auto fit = fit_camera(frames, cameras, static_cast<int>(c), rates);
      if (fit) {
        report_camera_fit(*fit, cameras[c], about, report);
        continue;
      }
      why_not =
          "too few frames with 12 common tracks that spread over the image, or too little turning";
    }
    report.not_checked.push_back(
        fmt::format("clock and rotation of {} against the IMU: {}", about, why_not));
  }
}

void check_tracks(const Recording& r, const std::vector<FeatureFrame>& tracks,
                  CheckReport& report) {
  if (!r.cameras.empty()) {
    report_stereo(r.cameras, tracks, report);
    check_turning(r, r.cameras, tracks, report);
  } else if (r.rig.fx > 0) {
    report_rectified(r.frames, report);
    check_turning(r, {left_camera(r.rig)}, left_frames(r.frames), report);
  }
}

}  // namespace

const char* severity_name(Severity severity) {
  switch (severity) {
    case Severity::kNote:
      return "note";
    case Severity::kWarning:
      return "warning";
    case Severity::kError:
      break;
  }
  return "error";
}

CheckReport check_recording(const Recording& recording) {
  return check_recording(recording, recording.frames);
}

CheckReport check_recording(const Recording& recording, const std::vector<FeatureFrame>& tracks) {
  CheckReport report;
  check_streams(recording, report);
  report_lenses(recording.cameras, report);
  check_axes(recording, report);
  check_velocity_clock(recording, report);
  check_coverage(recording, report);
  if (!recording.imu.empty()) {
    report_imu(recording.imu, range_of(recording), report);
    if (!has_no_measurement(recording.imu)) report_truth(recording, report);
    for (std::size_t c = 0; c < recording.cameras.size(); ++c) {
      report_camera_upright(recording, static_cast<int>(c), report);
    }
  }
  if (recording.images) {
    report_exposure(*recording.images, recording.cameras.size(), kImages, report);
  }
  check_tracks(recording, tracks, report);
  return report;
}

bool has_error(const CheckReport& report) {
  return std::any_of(report.findings.begin(), report.findings.end(),
                     [](const Finding& f) { return f.severity == Severity::kError; });
}

}  // namespace chasles
