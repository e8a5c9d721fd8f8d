#include <algorithm>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include <chasles/recording/sample_batches.hpp>
#include <chasles/recording/time_order.hpp>

namespace chasles {
namespace {

constexpr std::size_t kLargestBatch = 50;
constexpr std::size_t kLeastShare = 10;  // one of so many samples is in a batch
constexpr Time kLongestWait = std::chrono::milliseconds(200);

/// Neighbouring samples with one time: first to before first + count. `different` of them are no
/// copies of an earlier one.
struct SampleBatch {
  std::size_t first = 0, count = 1, different = 1;
  Time wait{};  // since the time before; 0: unknown
};

// For each sample of a batch, which of the different ones it is; all different unless each of them
// is there equally often.
std::vector<std::size_t> numbers_in(const std::vector<ImuSample>& imu, const SampleBatch& batch) {
  std::vector<std::size_t> numbers, originals, counts;
  for (std::size_t i = batch.first; i < batch.first + batch.count; ++i) {
    const auto same = std::ranges::find_if(
        originals, [&](std::size_t original) { return is_copy(imu[original], imu[i]); });
    numbers.push_back(static_cast<std::size_t>(same - originals.begin()));
    if (same == originals.end()) {
      originals.push_back(i);
      counts.push_back(0);
    }
    ++counts[numbers.back()];
  }
  const auto as_first = [&](std::size_t count) { return count == counts.front(); };
  if (counts.front() > 1 && std::ranges::all_of(counts, as_first)) return numbers;
  for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k] = k;
  return numbers;
}

std::vector<SampleBatch> find_batches(const std::vector<ImuSample>& imu) {
  std::vector<SampleBatch> batches;
  for (std::size_t i = 0; i < imu.size();) {
    SampleBatch batch{.first = i};
    while (i + batch.count < imu.size() && imu[i + batch.count].time == imu[i].time) ++batch.count;
    if (i > 0) batch.wait = std::max(Time{}, imu[i].time - imu[i - 1].time);
    i += batch.count;
    if (batch.count < 2 || batch.count > kLargestBatch) continue;
    const std::vector<std::size_t> numbers = numbers_in(imu, batch);
    batch.different = 1 + *std::ranges::max_element(numbers);
    if (batch.different > 1) batches.push_back(batch);
  }
  return batches;
}

// The median of the positive ones; 0 without any.
Time median_of(std::vector<Time> times) {
  std::erase_if(times, [](Time time) { return time <= Time{}; });
  if (times.empty()) return {};
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  return *middle;
}

void spread(const SampleBatch& batch, Time period, std::vector<ImuSample>& imu) {
  constexpr int kGap = 3;  // a wait of so many usual ones
  const auto count = static_cast<std::int64_t>(batch.different);
  const bool usual = batch.wait > Time{} && batch.wait <= kGap * count * period;
  const Time step = usual ? batch.wait / count : period;
  const std::vector<std::size_t> numbers = numbers_in(imu, batch);
  for (std::size_t k = 0; k < batch.count; ++k) {
    imu[batch.first + k].time -= (count - 1 - static_cast<std::int64_t>(numbers[k])) * step;
  }
}

}  // namespace

void spread_batches(std::vector<ImuSample>& imu, const std::string& what,
                    std::vector<std::string>& remarks) {
  const std::vector<SampleBatch> batches = find_batches(imu);
  std::size_t batched = 0, least = kLargestBatch, most = 0;
  std::vector<Time> waits, periods;
  for (const SampleBatch& batch : batches) {
    batched += batch.count;
    least = std::min(least, batch.different);
    most = std::max(most, batch.different);
    waits.push_back(batch.wait);
    periods.push_back(batch.wait / static_cast<std::int64_t>(batch.different));
  }
  const Time wait = median_of(waits), period = median_of(periods);
  if (kLeastShare * batched < imu.size() || period == Time{} || wait > kLongestWait) return;
  for (const SampleBatch& batch : batches) spread(batch, period, imu);
  const std::string sizes =
      least == most ? fmt::format("{}", most) : fmt::format("{} to {}", least, most);
  remarks.push_back(fmt::format(
      "{} of {} {} have the time of others with other values, in batches of {}, as a serial "
      "line or a FIFO delivers them: they are spread over the time since the batch before ({:.2f} "
      "ms from one to the next), and the last of a batch keeps its time",
      batched, imu.size(), what, sizes, 1e3 * to_seconds(period)));
}

}  // namespace chasles
