#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <chasles/check/camera_clock.hpp>
#include <chasles/check/clock_drift.hpp>

namespace chasles {
namespace {

constexpr double kSigmasOfDrift = 4;

std::vector<ImuSample> samples_around(const std::vector<ImuSample>& imu, Time begin, Time end) {
  constexpr Time kMargin = std::chrono::seconds(1);  // the search for the offset looks so far
  std::vector<ImuSample> part;
  for (const ImuSample& s : imu) {
    if (s.time > begin - kMargin && s.time < end + kMargin) part.push_back(s);
  }
  return part;
}

}  // namespace

bool ClockDrift::stands_out() const {
  return std::abs(rate) > std::max(kLeast, kSigmasOfDrift * sigma);
}

std::optional<ClockDrift> clock_drift(const std::vector<FeatureFrame>& tracks,
                                      const std::vector<Camera>& cameras,
                                      const std::vector<ImuSample>& imu) {
  if (tracks.size() < 3) return std::nullopt;
  const auto third = static_cast<std::ptrdiff_t>(tracks.size() / 3);
  const std::vector<FeatureFrame> first(tracks.begin(), tracks.begin() + third),
      last(tracks.end() - third, tracks.end());
  const auto clock_of = [&](const std::vector<FeatureFrame>& part) {
    return camera_clock(part, cameras, samples_around(imu, part.front().time, part.back().time));
  };
  const auto before = clock_of(first), after = clock_of(last);
  if (!before || !after) return std::nullopt;
  const double between = to_seconds(last.front().time - first.front().time);
  return ClockDrift{.rate = (after->offset - before->offset) / between,
                    .sigma = std::hypot(before->sigma, after->sigma) / between};
}

void report_clock_drift(const std::optional<ClockDrift>& drift, CheckReport& report) {
  if (!drift || !drift->stands_out()) return;
  report.findings.push_back(
      {.severity = Severity::kError,
       .about = "cam0",
       .what = fmt::format("its clock {} {:.2f} +- {:.2f} ms a second against the gyroscope's",
                           drift->rate > 0 ? "loses" : "gains", 1e3 * std::abs(drift->rate),
                           1e3 * drift->sigma),
       .value = 1e3 * std::abs(drift->rate),
       .threshold = 1e3 * ClockDrift::kLeast,
       .unit = "ms/s",
       .advice = "stamp images and samples by one clock; times that come from a frame rate need "
                 "the true one (29.97 a second, and not 30, is 1 ms a second)"});
}

}  // namespace chasles
