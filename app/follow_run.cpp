#include "follow_run.hpp"

#include <algorithm>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/run_folder/growing_run.hpp>
#include <chasles/session/report_run.hpp>

namespace chasles::app {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kBetweenReads{500};
constexpr int kShare = 10;

fs::file_time_type written(const fs::path& file) {
  std::error_code absent;
  const auto time = fs::last_write_time(file, absent);
  return absent ? fs::file_time_type::min() : time;
}

}  // namespace

FollowedRun::FollowedRun(fs::path folder, LiveRun& run)
    : folder_(std::move(folder)), run_(run), first_written_(written(growing_folder(folder_))) {}

void FollowedRun::poll() {
  const Clock::time_point start = Clock::now();
  if (ended_ || start < next_) return;
  try {
    const bool goes_on = is_growing(folder_);
    goes_on ? take(read_run(growing_folder(folder_))) : end();
  } catch (const InputError&) {
    // There are no files yet, or a row is incomplete: retried at the next call.
  }
  const Clock::time_point now = Clock::now();
  next_ = now + std::max<Clock::duration>(kBetweenReads, kShare * (now - start));
}

void FollowedRun::take(Run now) {
  if (now.states.empty()) return;
  if (!std::exchange(started_, true)) {
    run_.begin({.name = now.name,
                .extra_names = now.extra_names,
                .truth = now.truth,
                .pairing = now.pairing,
                .dead_reckoning = now.dead_reckoning,
                .summary = json_text(read_summary(growing_folder(folder_)))});
  }
  for (; shown_ < now.states.size(); ++shown_) run_.add(now.states[shown_]);
  run_.map([&] { return LiveMap{.landmarks = now.landmarks}; });
  run_.progress(shown_, to_seconds(now.states.back().time - now.states.front().time));
}

void FollowedRun::end() {
  ended_ = true;
  if (written(folder_ / "summary.json") < first_written_) {
    return run_.fail("the run ended without a result");
  }
  try {
    run_.finish(read_with_timing(folder_), false);
  } catch (const InputError& error) {
    run_.fail(error.what());
  }
}

}  // namespace chasles::app
