#include <algorithm>
#include <iterator>
#include <vector>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/check/check.hpp>
#include <chasles/check/clock_drift.hpp>
#include <chasles/session/check_tracks.hpp>
#include <chasles/session/check_trial.hpp>
#include <chasles/session/diagnosis.hpp>
#include <chasles/session/truth_preparation.hpp>

namespace chasles {
namespace {

std::vector<FeatureFrame> first_part(const std::vector<FeatureFrame>& frames, double seconds) {
  std::vector<FeatureFrame> part;
  for (const FeatureFrame& frame : frames) {
    if (frame.time - frames.front().time > from_seconds(seconds)) break;
    part.push_back(frame);
  }
  return part;
}

// `run`: also examines the truth, and tries the filter.
CheckReport report_with(const Recording& recording, double seconds,
                        const FrontendSettings& frontend, bool run) {
  if (!recording.images) {
    CheckReport report = check_recording(recording);
    if (run) {
      report_truth_examination(recording, report);
      report_trial(recording, first_part(recording.frames, seconds), report);
    }
    return report;
  }
  ImageTracks tracks = track_images(recording, seconds, frontend);
  CheckReport report = check_recording(recording, tracks.frames);
  report_clock_drift(clock_drift(tracks.frames, recording.cameras, recording.imu), report);
  if (run) report_truth_examination(recording, report);
  std::ranges::move(tracks.facts, std::back_inserter(report.facts));
  std::ranges::move(tracks.not_checked, std::back_inserter(report.not_checked));
  if (run) report_trial(recording, tracks.frames, report);
  return report;
}

}  // namespace

CheckReport diagnose(const Recording& recording, double seconds, const FrontendSettings& frontend) {
  return report_with(recording, seconds, frontend, true);
}

CheckReport examine(const Recording& recording, double seconds, const FrontendSettings& frontend) {
  return report_with(recording, seconds, frontend, false);
}

std::string finding_of_check(const Recording& recording, const FrontendSettings& frontend) {
  const char* const see = "see `chasles check`";
  CheckReport report;
  try {
    report = diagnose(recording, kCheckedSeconds, frontend);
  } catch (const Error&) {  // the run's own error stays the one that is shown
    return see;
  }
  // A trial of the filter without a cure says what the run says.
  std::erase_if(report.findings, [](const Finding& f) {
    return f.severity == Severity::kNote ||
           (f.about == "filter" && !f.advice.starts_with(kCureBegins));
  });
  if (report.findings.empty()) return see;
  const Finding& worst = *std::ranges::max_element(report.findings, {}, &Finding::severity);
  const std::string what = worst.about == "filter" ? worst.advice : worst.what;
  const std::string advice = worst.about == "filter" ? "" : "; " + worst.advice;
  return fmt::format("{}, which finds of {}: {}{}", see, worst.about, what, advice);
}

}  // namespace chasles
