#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <chasles/base/median.hpp>
#include <chasles/calibration/imu_range.hpp>
#include <chasles/check/check_imu.hpp>
#include <chasles/imu/sample_screen.hpp>
#include <chasles/recording/gravity.hpp>

namespace chasles {
namespace {

constexpr double kWindow = 0.5;              // [s]
constexpr double kShortestStandstill = 1.0;  // [s]
constexpr double kForceScatter = 0.2;        // [m/s^2]
constexpr double kRateScatter = 0.02;        // [rad/s]
constexpr double kStandstillRate = 0.2;      // [rad/s]
constexpr double kRepeatedShare = 0.05;
constexpr double kGravityOffAtStandstill = 0.3;  // [m/s^2]
constexpr double kGravityOffMoving = 1.5;        // [m/s^2]
constexpr double kUpsideDown = 135;              // [deg]

using Six = Eigen::Matrix<double, 6, 1>;

Six as_vector(const ImuSample& s) {
  Six x;
  x << s.specific_force_imu, s.angular_rate_imu;
  return x;
}

// The samples [begin, end) as a standstill, if they are one.
bool is_standstill(const std::vector<ImuSample>& imu, std::size_t begin, std::size_t end,
                   StandstillSpan& standstill) {
  const auto n = static_cast<double>(end - begin);
  Six mean = Six::Zero(), scatter = Six::Zero();
  for (std::size_t i = begin; i < end; ++i) mean += as_vector(imu[i]) / n;
  for (std::size_t i = begin; i < end; ++i) scatter += (as_vector(imu[i]) - mean).cwiseAbs2() / n;
  standstill = {.begin = imu[begin].time,
                .end = imu[end - 1].time,
                .specific_force_imu = mean.head<3>(),
                .angular_rate_imu = mean.tail<3>()};
  return std::sqrt(scatter.head<3>().sum()) < kForceScatter &&
         std::sqrt(scatter.tail<3>().sum()) < kRateScatter &&
         mean.tail<3>().norm() < kStandstillRate;
}

void join(StandstillSpan& standstill, const StandstillSpan& next) {
  const double a = to_seconds(standstill.end - standstill.begin),
               b = to_seconds(next.end - next.begin);
  standstill.specific_force_imu =
      (a * standstill.specific_force_imu + b * next.specific_force_imu) / (a + b);
  standstill.angular_rate_imu =
      (a * standstill.angular_rate_imu + b * next.angular_rate_imu) / (a + b);
  standstill.end = next.end;
}

// The longest standstill; null without any.
const StandstillSpan* longest(const std::vector<StandstillSpan>& standstills) {
  const auto found = std::max_element(standstills.begin(), standstills.end(),
                                      [](const StandstillSpan& a, const StandstillSpan& b) {
                                        return a.end - a.begin < b.end - b.begin;
                                      });
  return found == standstills.end() ? nullptr : &*found;
}

double median_force(const std::vector<ImuSample>& imu) {
  std::vector<double> sizes;
  for (const ImuSample& s : imu) sizes.push_back(s.specific_force_imu.norm());
  return median(std::move(sizes));
}

std::string gravity_advice(double size) {
  if (std::abs(size - 1) < 0.2) return "the unit seems to be g: multiply the accelerometer by 9.81";
  if (size < kStandardGravity / 2) {
    return "gravity seems to be removed (linear acceleration): record the raw specific force";
  }
  return "check the accelerometer's unit (m/s^2) and scale";
}

void report_gravity_size(const std::vector<ImuSample>& imu, const StandstillSpan* standstill,
                         CheckReport& report) {
  const double size = standstill ? standstill->specific_force_imu.norm() : median_force(imu);
  const double limit = standstill ? kGravityOffAtStandstill : kGravityOffMoving;
  const char* when = standstill ? "at a standstill" : "in the median of all samples";
  report.facts.push_back({"imu", standstill ? "force at rest" : "median force", size, "m/s^2"});
  if (std::abs(size - kStandardGravity) <= limit) return;
  report.findings.push_back(
      {.severity = std::abs(size - kStandardGravity) > 2 ? Severity::kError : Severity::kWarning,
       .about = "imu",
       .what = fmt::format("the accelerometer shows {:.2f} m/s^2 {}, and gravity is {:.2f}", size,
                           when, kStandardGravity),
       .value = std::abs(size - kStandardGravity),
       .threshold = limit,
       .unit = "m/s^2",
       .advice = gravity_advice(size)});
}

void report_saturation(const std::vector<ImuSample>& imu, const ImuRange& range,
                       CheckReport& report) {
  if (std::isfinite(range.accelerometer)) {
    report.facts.push_back({"imu", "force range", range.accelerometer, "m/s^2"});
  }
  if (std::isfinite(range.gyroscope)) {
    report.facts.push_back({"imu", "rate range", range.gyroscope, "rad/s"});
  }
  const std::size_t saturated = count_saturated(imu, range);
  if (saturated == 0) return;
  report.findings.push_back(
      {.severity = Severity::kWarning,
       .about = "imu",
       .what = fmt::format("{} samples are at the edge of the sensor's range", saturated),
       .value = static_cast<double>(saturated),
       .threshold = 0,
       .unit = "samples",
       .advice = "choose a larger range, or damp the sensor's mount"});
}

void report_repeats(const std::vector<ImuSample>& imu, CheckReport& report) {
  std::size_t repeats = 0;
  for (std::size_t i = 1; i < imu.size(); ++i) {
    repeats += as_vector(imu[i]) == as_vector(imu[i - 1]) ? 1 : 0;
  }
  const double share = static_cast<double>(repeats) / static_cast<double>(imu.size());
  if (share <= kRepeatedShare) return;
  report.findings.push_back(
      {.severity = Severity::kNote,
       .about = "imu",
       .what = fmt::format("{:.0f} % of the samples are the same as the one before", 100 * share),
       .value = 100 * share,
       .threshold = 100 * kRepeatedShare,
       .unit = "%",
       .advice = "the sensor is read faster than it measures: read it at its own rate"});
}

// An axis that shows one number while the others move is not connected, or not read.
void report_dead_axes(const std::vector<ImuSample>& imu, CheckReport& report) {
  constexpr std::size_t kFewestSamples = 100;
  if (imu.size() < kFewestSamples) return;
  Six low = as_vector(imu.front()), high = low;
  for (const ImuSample& sample : imu) {
    low = low.cwiseMin(as_vector(sample));
    high = high.cwiseMax(as_vector(sample));
  }
  const bool moves = (high - low).maxCoeff() > 0;
  for (int i = 0; moves && i < 6; ++i) {
    if (high[i] > low[i]) continue;
    report.findings.push_back(
        {.severity = Severity::kError,
         .about = "imu",
         .what = fmt::format("the {}'s {} axis shows {:g} {} in all samples",
                             i < 3 ? "accelerometer" : "gyroscope", "xyz"[i % 3], low[i],
                             i < 3 ? "m/s^2" : "rad/s"),
         .value = 0,
         .threshold = 0,
         .unit = i < 3 ? "m/s^2" : "rad/s",
         .advice = "a run needs all six axes: check the driver and the columns"});
  }
}

// By the rules of a run (SampleScreen).
void report_no_measurements(const std::vector<ImuSample>& imu, const ImuRange& range,
                            CheckReport& report) {
  SampleScreen screen(range);
  std::optional<Time> first;
  int left_out = 0;
  for (const ImuSample& sample : imu) {
    screen.add(sample);
    const SampleScreen::Counts& c = screen.counts();
    left_out = c.zero + c.spikes + c.frozen;
    if (left_out > 0 && !first) first = sample.time;
  }
  if (left_out == 0) return;
  const SampleScreen::Counts& c = screen.counts();
  report.findings.push_back(
      {.severity = Severity::kWarning,
       .about = "imu",
       .what =
           fmt::format("{} samples are no measurements: {} of six zeros, {} spikes, {} of a "
                       "sensor that repeats its numbers; the first after {:.2f} s",
                       left_out, c.zero, c.spikes, c.frozen, to_seconds(*first - imu.front().time)),
       .value = static_cast<double>(left_out),
       .threshold = 0,
       .unit = "samples",
       .advice = "a run leaves them out and bridges the gaps; check the driver and the cable"});
}

// Somebody has filled a gap.
void report_interpolated(const std::vector<ImuSample>& imu, const ImuRange& range,
                         CheckReport& report) {
  struct Stretch {
    std::size_t first, end;
  };
  constexpr std::size_t kMostNamed = 3;
  SampleScreen screen(range);
  std::vector<Stretch> stretches;
  int before = 0;
  for (std::size_t i = 0; i < imu.size(); ++i) {
    screen.add(imu[i]);
    const auto more = static_cast<std::size_t>(screen.counts().interpolated - before);
    before = screen.counts().interpolated;
    if (more == 1 && !stretches.empty()) stretches.back().end = i;
    if (more > 1) stretches.push_back({i - more, i});  // until now it was not decided
  }
  if (stretches.empty()) return;
  std::string named;
  for (std::size_t k = 0; k < std::min(kMostNamed, stretches.size()); ++k) {
    const auto seconds = [&](std::size_t i) { return to_seconds(imu[i].time - imu.front().time); };
    named += fmt::format("{}{:.2f} to {:.2f} s", k > 0 ? ", " : "", seconds(stretches[k].first),
                         seconds(stretches[k].end));
  }
  const std::size_t others = stretches.size() - std::min(kMostNamed, stretches.size());
  report.findings.push_back(
      {.severity = Severity::kWarning,
       .about = "imu",
       .what = fmt::format("{} samples are interpolated: they lie on straight lines, {}{}", before,
                           named, others > 0 ? fmt::format(" and {} more", others) : ""),
       .value = static_cast<double>(before),
       .threshold = 0,
       .unit = "samples",
       .advice = "somebody has filled gaps of the IMU: record without, or leave the gaps empty; a "
                 "run takes them for gaps, does not start there, and starts anew after 0.5 s"});
}

void report_attitude_alone(std::size_t samples, CheckReport& report) {
  report.findings.push_back(
      {.severity = Severity::kError,
       .about = "imu",
       .what = fmt::format("all {} samples have angular rates and specific forces of 0: the topic "
                           "or table may hold the attitude alone",
                           samples),
       .value = static_cast<double>(samples),
       .threshold = 0,
       .unit = "samples",
       .advice = "record gyroscope and accelerometer: the driver's raw topic, often imu/data_raw, "
                 "or a setting of the driver turns them on"});
}

}  // namespace

bool has_no_measurement(const std::vector<ImuSample>& imu) {
  return !imu.empty() && std::ranges::all_of(imu, [](const ImuSample& s) {
    return s.specific_force_imu.isZero(0) && s.angular_rate_imu.isZero(0);
  });
}

std::vector<StandstillSpan> find_standstills(const std::vector<ImuSample>& imu) {
  std::vector<StandstillSpan> standstills;
  bool standing = false;
  for (std::size_t begin = 0, end = 0; begin < imu.size(); begin = end) {
    while (end < imu.size() && to_seconds(imu[end].time - imu[begin].time) < kWindow) ++end;
    StandstillSpan standstill;
    if (end - begin < 5 || !is_standstill(imu, begin, end, standstill)) {
      standing = false;
    } else if (standing) {
      join(standstills.back(), standstill);
    } else {
      standstills.push_back(standstill);
      standing = true;
    }
  }
  // A window ends one sample before the next one starts.
  std::erase_if(standstills, [](const StandstillSpan& r) {
    return to_seconds(r.end - r.begin) < 0.95 * kShortestStandstill;
  });
  return standstills;
}

void report_imu(const std::vector<ImuSample>& imu, const ImuRange& range, CheckReport& report) {
  if (has_no_measurement(imu)) {
    report_attitude_alone(imu.size(), report);
    return;
  }
  const std::vector<StandstillSpan> standstills = find_standstills(imu);
  double seconds = 0;
  for (const StandstillSpan& standstill : standstills)
    seconds += to_seconds(standstill.end - standstill.begin);
  report.facts.push_back({"imu", "at rest", seconds, "s"});
  if (const StandstillSpan* standstill = longest(standstills)) {
    report.facts.push_back({"imu", "rate at rest", standstill->angular_rate_imu.norm(), "rad/s"});
  }
  report_gravity_size(imu, longest(standstills), report);
  report_saturation(imu, range, report);
  report_repeats(imu, report);
  report_dead_axes(imu, report);
  report_no_measurements(imu, range, report);
  report_interpolated(imu, range, report);
}

void report_camera_upright(const Recording& recording, int index, CheckReport& report) {
  if (has_no_measurement(recording.imu)) return;
  const std::vector<StandstillSpan> standstills = find_standstills(recording.imu);
  const StandstillSpan* standstill = longest(standstills);
  if (!standstill) return;
  const Camera& camera = recording.cameras[static_cast<std::size_t>(index)];
  const Eigen::Vector3d up = (camera.cam_T_imu.R * standstill->specific_force_imu).normalized();
  const double roll = std::atan2(up.x(), -up.y()) * 180 / std::numbers::pi;
  const double pitch = std::asin(std::clamp(up.z(), -1.0, 1.0)) * 180 / std::numbers::pi;
  const std::string about = fmt::format("cam{}", index);
  report.facts.push_back({about, "roll at rest", roll, "deg"});
  report.facts.push_back({about, "pitch at rest", pitch, "deg"});
  if (std::abs(roll) < kUpsideDown || std::abs(pitch) > 90 - kUpsideDown / 2) return;
  report.findings.push_back(
      {.severity = Severity::kWarning,
       .about = about,
       .what =
           fmt::format("at a standstill the camera is upside down: its roll is {:.0f} deg", roll),
       .value = std::abs(roll),
       .threshold = kUpsideDown,
       .unit = "deg",
       .advice =
           "unless it is mounted so, the accelerometer has the wrong sign (with z up it shows "
           "+9.81), or the extrinsics are wrong"});
}

}  // namespace chasles
