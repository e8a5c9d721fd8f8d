#include <algorithm>
#include <exception>
#include <iterator>
#include <optional>
#include <utility>

#include <chasles/base/error.hpp>
#include <chasles/imu/time_gaps.hpp>
#include <chasles/pipeline/batch_input.hpp>
#include <chasles/pipeline/batch_parts.hpp>

namespace chasles {
namespace {

constexpr Time kLongestGap = InertialSession::kLongestGap;

// Samples without a gap: those from `begin` on, whose times are in [first, last].
struct Stretch {
  std::size_t begin = 0;
  Time first{}, last{};
};

std::vector<Stretch> stretches(const std::vector<ImuSample>& samples) {
  std::vector<Stretch> all;
  TimeGaps gaps;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Time time = samples[i].time;
    if (gaps.add(time) || all.empty()) all.push_back({.begin = i, .first = time, .last = time});
    all.back().last = time;
  }
  return all;
}

// The material of one stretch. At the end of the recording frames may be that much later than the
// last sample; before a gap they are left out, because the motion there is known the less.
BatchMaterial part_of(const BatchMaterial& all, const std::vector<Stretch>& stretches,
                      std::size_t k, Time offset) {
  const Stretch& own = stretches[k];
  const bool last = k + 1 == stretches.size();
  const Time end = last ? own.last + kLongestGap : own.last;
  const auto inside = [&](Time time) { return own.first <= time && time <= end; };
  BatchMaterial part;
  const auto begin = all.samples.begin();
  part.samples.assign(
      begin + static_cast<std::ptrdiff_t>(own.begin),
      last ? all.samples.end() : begin + static_cast<std::ptrdiff_t>(stretches[k + 1].begin));
  std::ranges::copy_if(all.frames, std::back_inserter(part.frames),
                       [&](const FeatureFrame& f) { return inside(f.time + offset); });
  std::ranges::copy_if(all.estimates, std::back_inserter(part.estimates),
                       [&](const Estimate& e) { return inside(e.time); });
  part.starts = all.starts;
  return part;
}

// One part, which then says where the gap is, if no stretch has an estimate.
std::vector<BatchMaterial> divided(BatchMaterial material, Time offset) {
  const std::vector<Stretch> all = stretches(material.samples);
  std::vector<BatchMaterial> parts;
  for (std::size_t k = 0; k < all.size() && all.size() > 1; ++k) {
    BatchMaterial part = part_of(material, all, k, offset);
    if (!part.estimates.empty()) parts.push_back(std::move(part));
  }
  if (parts.empty()) parts.push_back(std::move(material));
  return parts;
}

// The calibration that the filter found last, with a sound estimate.
std::optional<Calibration> found_calibration(const std::vector<Estimate>& estimates) {
  const auto sound = std::find_if(estimates.rbegin(), estimates.rend(),
                                  [](const Estimate& e) { return e.health != Health::kLost; });
  return sound == estimates.rend() ? std::nullopt : sound->calibration;
}

// At which the filter began with its first estimate.
std::optional<InertialStart> start_of(const BatchMaterial& part) {
  const auto start =
      std::ranges::find(part.starts, part.estimates.front().time, &InertialStart::time);
  return start == part.starts.end() ? std::nullopt : std::optional(*start);
}

// Takes samples and frames. `initial`: where the search begins with the calibration; `known`: what
// earlier parts know of it.
InertialBatchInput part_input(const InertialSensors& sensors, const InertialRunSettings& settings,
                              const std::optional<Calibration>& initial,
                              const std::optional<Calibration>& known, BatchMaterial& part) {
  InertialBatchInput input =
      batch_input(sensors, settings.filter, start_at(part.estimates.front(), start_of(part)));
  if (initial) begin_at(*initial, sensors.cameras, part.estimates.front(), input);
  if (known) input.calibration = known;
  for (const Estimate& e : part.estimates) {
    input.initial.push_back(timed_motion(e, input.time_offset));
  }
  input.samples = std::move(part.samples);
  input.frames = std::move(part.frames);
  return input;
}

InertialBatchResult smooth_part(InertialBatchInput input, const InertialRunSettings& settings,
                                bool later, const StopRequest& stop) {
  std::optional<Place> place;
  if (later) place = take_place(input);
  InertialBatchResult result = smooth(input, settings.filter.chart, settings.batch, stop);
  if (!place) return result;
  for (Estimate& e : result.estimates) add_place(*place, e);
  for (MapLandmark& l : result.landmarks) add_place(*place, l);
  return result;
}

void add(const BatchReport& more, BatchReport& sum) {
  const int observations = sum.observations + more.observations;
  sum.cost_per_dof = (sum.cost_per_dof * sum.observations + more.cost_per_dof * more.observations) /
                     std::max(observations, 1);
  for (int BatchReport::*count :
       {&BatchReport::keyframes, &BatchReport::links, &BatchReport::observations,
        &BatchReport::unusable, &BatchReport::gated, &BatchReport::outliers,
        &BatchReport::dropped_frames, &BatchReport::landmarks, &BatchReport::landmarks_left_out,
        &BatchReport::landmarks_split, &BatchReport::iterations, &BatchReport::successful,
        &BatchReport::parts}) {
    sum.*count += more.*count;
  }
  for (double BatchReport::*number :
       {&BatchReport::initial_cost, &BatchReport::final_cost, &BatchReport::seconds_solve,
        &BatchReport::seconds_covariance}) {
    sum.*number += more.*number;
  }
  sum.costs.insert(sum.costs.end(), more.costs.begin(), more.costs.end());
  sum.decrease_left = std::max(sum.decrease_left, more.decrease_left);
  sum.covariance_factor = std::max(sum.covariance_factor, more.covariance_factor);
  sum.converged = sum.converged && more.converged;
  sum.stalled = sum.stalled || more.stalled;
  for (const std::string& name : more.unobservable) {
    if (std::ranges::find(sum.unobservable, name) == sum.unobservable.end()) {
      sum.unobservable.push_back(name);
    }
  }
}

void append(InertialBatchResult part, bool first, InertialBatchResult& all) {
  if (first) {
    all.report = std::move(part.report);
  } else {
    add(part.report, all.report);
  }
  all.estimates.insert(all.estimates.end(), part.estimates.begin(), part.estimates.end());
  all.landmarks.insert(all.landmarks.end(), part.landmarks.begin(), part.landmarks.end());
  all.terms.insert(all.terms.end(), part.terms.begin(), part.terms.end());
}

}  // namespace

InertialBatchResult smooth_parts(const InertialSensors& sensors,
                                 const InertialRunSettings& settings, BatchMaterial material,
                                 const StopRequest& stop) {
  InertialBatchResult all;
  int done = 0, failed = 0;
  std::string failure;
  std::exception_ptr first_error;
  std::optional<Calibration> initial = found_calibration(material.estimates), known;
  const double offset = initial && initial->time_offset ? *initial->time_offset
                                                        : settings.filter.initial_time_offset();
  std::vector<BatchMaterial> parts = divided(std::move(material), from_seconds(offset));
  for (BatchMaterial& part : parts) {
    InertialBatchInput input = part_input(sensors, settings, initial, known, part);
    try {
      append(smooth_part(std::move(input), settings, &part != &parts.front(), stop), done == 0,
             all);
      ++done;
      initial = known = all.estimates.back().calibration;
    } catch (const Error& error) {
      if (!first_error) {
        first_error = std::current_exception();
        failure = error.what();
      }
      ++failed;
      all.estimates.insert(all.estimates.end(), part.estimates.begin(), part.estimates.end());
    }
  }
  if (done == 0) std::rethrow_exception(first_error);
  all.report.parts = done + failed;
  all.report.parts_failed = failed;
  all.report.failure = failure;
  return all;
}

}  // namespace chasles
