#include <algorithm>
#include <chrono>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/live/gate.hpp>
#include <chasles/live/live_run.hpp>
#include <chasles/live/live_text.hpp>

namespace chasles {
namespace {

/// States in one text: a late viewer receives the run in pieces of a few hundred kilobytes.
constexpr std::size_t kMostRows = 2000;
constexpr std::size_t kKeptTexts = 8;

LiveText shared(std::string text) { return std::make_shared<const std::string>(std::move(text)); }

}  // namespace

LiveRun::LiveRun(std::function<void()> stop) : id_(random_token()), stop_(std::move(stop)) {
  reported_.stoppable = progress_.stoppable = static_cast<bool>(stop_);
}

void LiveRun::begin(LiveStart start) {
  start_time_ = Clock::now();
  reported_.of = start.frames;
  if (start.summary.empty()) start.summary = "{}";
  const std::lock_guard lock(mutex_);
  inbox_.start = std::move(start);
  inbox_.progress = reported_;
}

void LiveRun::add(const RunState& state) {
  if (reported_.stage == LiveStage::kWaiting) reported_.stage = LiveStage::kRunning;
  const std::lock_guard lock(mutex_);
  inbox_.states.push_back(state);
}

void LiveRun::progress(std::size_t frames, double recorded_seconds) {
  reported_.frames = frames;
  reported_.recorded_seconds = recorded_seconds;
  report_progress(reported_.stage);
}

void LiveRun::report_progress(LiveStage stage) {
  reach(stage);
  const std::lock_guard lock(mutex_);
  inbox_.progress = reported_;
}

void LiveRun::reach(LiveStage stage) {
  reported_.stage = stage;
  reported_.wall_seconds = std::chrono::duration<double>(Clock::now() - start_time_).count();
}

void LiveRun::map(const std::function<LiveMap()>& make) {
  if (!watched_ || !maps_.is_due()) return;
  LiveMap map = maps_(make);
  const std::lock_guard lock(mutex_);
  inbox_.map = std::move(map);
}

void LiveRun::smoothing() { report_progress(LiveStage::kSmoothing); }

void LiveRun::finish(const ReportRun& run, bool interrupted) {
  // Both at once: a viewer that learns of the end has all of it.
  reach(interrupted ? LiveStage::kInterrupted : LiveStage::kFinished);
  LiveText all = shared(page_text(id_, {run}, reported_));
  const std::lock_guard lock(mutex_);
  inbox_.progress = reported_;
  inbox_.all = std::move(all);
}

void LiveRun::fail(const std::string& why) {
  reported_.message = why;
  report_progress(LiveStage::kFailed);
}

void LiveRun::take_start(LiveStart start) {
  run_ = {};
  run_.name = std::move(start.name);
  run_.extra_names = std::move(start.extra_names);
  run_.dead_reckoning = std::move(start.dead_reckoning);
  summary_ = std::move(start.summary);
  comparison_ = {std::move(start.truth), start.pairing, coordinates_of(summary_), is_level(run_)};
  started_ = true;
}

void LiveRun::refresh(std::size_t viewers) {
  watched_ = viewers > 0;
  Inbox news;
  {
    const std::lock_guard lock(mutex_);
    std::swap(news, inbox_);
  }
  if (news.start) take_start(std::move(*news.start));
  std::ranges::move(news.states, std::back_inserter(run_.states));
  if (news.map) {
    run_.landmarks = std::move(news.map->landmarks);
    known_ = std::move(news.map->known);
    if (!run_.prior_map) run_.prior_map = std::move(news.map->prior_map);
    ++landmarks_version_;
  }
  if (news.progress) {
    progress_ = std::move(*news.progress);
    ++progress_version_;
  }
  if (news.all) all_ = std::move(news.all);
}

bool LiveRun::has_news(const LiveCursor& have, const LiveCursor& then) const {
  return have.rows != then.rows || have.landmarks != then.landmarks || have.truth != then.truth ||
         have.prior_map != then.prior_map || have.progress != then.progress;
}

LiveText LiveRun::next(LiveCursor& cursor) {
  if (cursor.run != id_ || cursor.rows > run_.states.size()) cursor = {.run = id_};
  if (all_) {
    if (cursor.all) return nullptr;
    cursor.all = true;
    return all_;
  }
  comparison_.extend(run_.states);
  LiveCursor then = cursor;
  then.progress = progress_version_;
  then.rows = std::min(run_.states.size(), cursor.rows + kMostRows);
  const bool up_to_date = then.rows == run_.states.size() && then.rows > 0;
  if (up_to_date) then.landmarks = landmarks_version_;
  if (then.rows > 0) then.truth = comparison_.started();
  if (up_to_date) then.prior_map = run_.prior_map.has_value();
  if (!has_news(cursor, then)) return nullptr;
  LiveText text = rows_text(cursor, then);
  cursor = then;
  return text;
}

LiveText LiveRun::rows_text(const LiveCursor& have, const LiveCursor& then) {
  const LiveRows rows{
      .id = id_,
      .from = have.rows,
      .to = then.rows,
      .truth = then.truth && !have.truth,
      .landmarks = then.landmarks != have.landmarks ? then.landmarks : 0,
      .prior_map = then.prior_map && !have.prior_map,
  };
  const std::string key = fmt::format("{} {} {} {} {} {}", rows.from, rows.to, rows.truth,
                                      rows.landmarks, rows.prior_map, then.progress);
  const auto known = std::ranges::find(texts_, key, &std::pair<std::string, LiveText>::first);
  if (known != texts_.end()) return known->second;
  LiveText text = shared(
      then.rows == 0 ? progress_text(id_, progress_)
                     : chasles::rows_text(run_, {summary_, known_}, comparison_, rows, progress_));
  if (texts_.size() >= kKeptTexts) texts_.erase(texts_.begin());
  texts_.emplace_back(key, text);
  return text;
}

FinishedRuns::FinishedRuns(const std::vector<ReportRun>& runs)
    : id_(random_token()), all_(shared(page_text(id_, runs, {.stage = LiveStage::kFinished}))) {}

LiveText FinishedRuns::next(LiveCursor& cursor) {
  if (cursor.run == id_ && cursor.all) return nullptr;
  cursor = {.run = id_, .all = true};
  return all_;
}

}  // namespace chasles
