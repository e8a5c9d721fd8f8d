#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>
#include <utility>

#include <chasles/base/constants.hpp>
#include <chasles/lab/monte_carlo.hpp>
#include <chasles/lab/workers.hpp>
#include <chasles/sim/inertial_sim.hpp>

namespace chasles {
namespace {

double median(std::vector<double> values) {
  std::erase_if(values, [](double v) { return std::isnan(v); });
  if (values.empty()) return kNaN;
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
}

// The mean of a member over items, without NaN.
template <typename Items, typename Member>
double mean_of(const Items& items, const Member& member) {
  double sum = 0;
  std::size_t count = 0;
  for (const auto& item : items) {
    const double value = member(item);
    if (std::isnan(value)) continue;
    sum += value;
    ++count;
  }
  return count == 0 ? kNaN : sum / static_cast<double>(count);
}

template <typename Items>
TrialRecord::Second mean_second(const Items& items) {
  using S = TrialRecord::Second;
  const auto of = [&](double S::*member) {
    return mean_of(items, [&](const S& s) { return s.*member; });
  };
  return {.position_error = of(&S::position_error),
          .attitude_error = of(&S::attitude_error),
          .nees_position = of(&S::nees_position),
          .nees_attitude = of(&S::nees_attitude),
          .nees_pose = of(&S::nees_pose),
          .nees_state = of(&S::nees_state)};
}

constexpr int kPoseDof = 6;

using Records = std::vector<const TrialRecord*>;

// In the order of the runs, so that sums are reproducible to the byte.
Records records_of(const FilterVariant& filter, std::span<const TrialRecord> records) {
  Records own;
  for (const TrialRecord& record : records) {
    if (record.filter == filter.name) own.push_back(&record);
  }
  std::ranges::sort(own, {}, &TrialRecord::run);
  return own;
}

void add_averages(const Records& own, FilterSummary& summary) {
  for_each_average([&](double TrialAverages::*member) {
    std::vector<double> values;
    for (const TrialRecord* r : own) values.push_back(r->averages.*member);
    summary.mean.*member = mean_of(values, [](double value) { return value; });
    summary.median.*member = median(std::move(values));
  });
  summary.nees_per_dof = summary.mean.nees_pose / kPoseDof;
  summary.covariance_factor = summary.nees_per_dof;
}

// Needs the band.
void add_seconds(const Records& own, FilterSummary& summary) {
  std::size_t longest = 0;
  for (const TrialRecord* r : own) longest = std::max(longest, r->seconds.size());
  std::size_t inside = 0;
  std::size_t counted = 0;
  for (std::size_t second = 0; second < longest; ++second) {
    std::vector<TrialRecord::Second> of_runs;
    for (const TrialRecord* r : own) {
      if (second < r->seconds.size()) of_runs.push_back(r->seconds[second]);
    }
    summary.seconds.push_back(mean_second(of_runs));
    const double nees = summary.seconds.back().nees_pose / kPoseDof;
    if (std::isnan(nees)) continue;
    ++counted;
    inside += summary.band.contains(nees) ? 1 : 0;
  }
  summary.seconds_inside =
      counted == 0 ? kNaN : static_cast<double>(inside) / static_cast<double>(counted);
}

std::vector<TrialRecord> records_of_run(const MonteCarloPlan& plan, std::uint64_t run) {
  const Recording recording = simulate_inertial(plan.scene, run);
  std::vector<TrialRecord> records;
  for (const FilterVariant& filter : plan.filters) {
    const InertialStart start =
        draw_start(recording, filter.settings, plan.scene.settings.seed, run);
    const KeepMap keep_map = filter.settings.keeps_exact_map() ? KeepMap::kYes : KeepMap::kNo;
    Trial trial = run_trial(filter, recording, start, keep_map);
    trial.run = run;
    records.push_back(record_of(trial));
  }
  return records;
}

// Records sent between processes of this program on this machine, in the memory layout of numbers.
class Bytes {
 public:
  explicit Bytes(std::string bytes = {}) : bytes_(std::move(bytes)) {}

  template <typename T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  template <typename T>
  T get() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value;
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  bool at_end() const { return at_ == bytes_.size(); }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

std::string to_bytes(const std::vector<TrialRecord>& records) {
  Bytes bytes;
  for (const TrialRecord& record : records) {
    bytes.put(record.filter.size());
    for (const char c : record.filter) bytes.put(c);
    bytes.put(record.run);
    bytes.put(record.diverged);
    bytes.put(record.averages);
    for (const auto* seconds : {&record.seconds, &record.smoothed}) {
      bytes.put(seconds->size());
      for (const TrialRecord::Second& second : *seconds) bytes.put(second);
    }
  }
  return bytes.bytes();
}

std::vector<TrialRecord> from_bytes(const std::string& text) {
  Bytes bytes(text);
  std::vector<TrialRecord> records;
  while (!bytes.at_end()) {
    TrialRecord record;
    record.filter.resize(bytes.get<std::size_t>());
    for (char& c : record.filter) c = bytes.get<char>();
    record.run = bytes.get<std::uint64_t>();
    record.diverged = bytes.get<bool>();
    record.averages = bytes.get<TrialAverages>();
    for (auto* seconds : {&record.seconds, &record.smoothed}) {
      seconds->resize(bytes.get<std::size_t>());
      for (TrialRecord::Second& second : *seconds) second = bytes.get<TrialRecord::Second>();
    }
    records.push_back(std::move(record));
  }
  return records;
}

std::vector<TrialRecord::Second> seconds_of(const std::vector<TrialPoint>& points) {
  std::vector<std::vector<TrialRecord::Second>> seconds;
  for (const TrialPoint& point : points) {
    const auto second = static_cast<std::size_t>(point.seconds);
    if (seconds.size() <= second) seconds.resize(second + 1);
    seconds[second].push_back({.position_error = point.position_error,
                               .attitude_error = point.attitude_error,
                               .nees_position = point.nees_position,
                               .nees_attitude = point.nees_attitude,
                               .nees_pose = point.nees_pose,
                               .nees_state = point.nees_state});
  }
  std::vector<TrialRecord::Second> means;
  for (const auto& second : seconds) means.push_back(mean_second(second));
  return means;
}

}  // namespace

TrialRecord record_of(const Trial& trial) {
  return {.filter = trial.filter,
          .run = trial.run,
          .diverged = trial.diverged,
          .averages = averages(trial),
          .seconds = seconds_of(trial.points),
          .smoothed = seconds_of(trial.smoothed)};
}

void run_monte_carlo(const std::vector<std::uint64_t>& runs, int workers,
                     const RecordsOfRun& records, const RecordsDone& done) {
  work_in_processes(
      runs, workers, [&](std::uint64_t run) { return to_bytes(records(run)); },
      [&](std::uint64_t, const std::string& bytes) { done(from_bytes(bytes)); });
}

void run_monte_carlo(const MonteCarloPlan& plan, int workers, const RecordsDone& done) {
  run_monte_carlo(
      plan.runs, workers, [&](std::uint64_t run) { return records_of_run(plan, run); }, done);
}

std::vector<FilterSummary> summarize(std::span<const FilterVariant> filters,
                                     std::span<const TrialRecord> records) {
  std::vector<FilterSummary> result;
  for (const FilterVariant& filter : filters) {
    Records own = records_of(filter, records);
    FilterSummary summary{.filter = filter.name, .runs = own.size()};
    std::erase_if(own, [](const TrialRecord* record) { return record->diverged; });
    summary.diverged = summary.runs - own.size();
    add_averages(own, summary);
    if (!own.empty()) {
      const Band sum = chi2_band(kPoseDof, own.size());
      summary.band = {.low = sum.low / kPoseDof, .high = sum.high / kPoseDof};
    }
    add_seconds(own, summary);
    result.push_back(std::move(summary));
  }
  return result;
}

}  // namespace chasles
