#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <chasles/live/comparison.hpp>
#include <chasles/live/feed.hpp>
#include <chasles/report/report.hpp>

namespace chasles {

/// What is known of a run before its first estimate.
struct LiveStart {
  std::string name;
  std::vector<std::string> extra_names;   ///< Run::extra_names
  Trajectory truth, dead_reckoning = {};  ///< empty where unknown
  /// What is known of summary.json (an object): chart, mode, settings, cameras, version.
  std::string summary;
  std::size_t frames = 0;  ///< of the recording; 0: nobody knows
};

/// Where a run is. The names are those of the protocol.
enum class LiveStage {
  kWaiting,      ///< there is no estimate yet
  kRunning,      ///< frames are worked through
  kSmoothing,    ///< batch estimation after the last frame
  kFinished,     ///< all is there
  kInterrupted,  ///< ended early, by a signal or a viewer; what there is is complete
  kFailed,       ///< ended with an error
};

/// How far a run is.
struct LiveProgress {
  LiveStage stage = LiveStage::kWaiting;
  std::size_t frames = 0, of = 0;  ///< done, of all; of 0: nobody knows
  double recorded_seconds = 0;     ///< that the frames cover
  double wall_seconds = 0;         ///< that they took
  std::string message = {};        ///< why it failed
  bool stoppable = true;           ///< a viewer may ask it to end
};

/// A run that viewers look at while it goes. The run's thread tells it what happens: that never
/// waits for a viewer, copies a state under a lock that is held for a moment, and changes nothing
/// about the run. The server's thread makes of it what viewers are told.
class LiveRun final : public LiveFeed {
 public:
  /// `stop`: asks the run to end, from the server's thread; empty: nobody can.
  explicit LiveRun(std::function<void()> stop);

  // The run's thread.

  void begin(LiveStart start);
  void add(const RunState& state);
  /// That many frames are done, which cover that many seconds of the recording.
  void progress(std::size_t frames, double recorded_seconds);
  /// Keeps the map that `make` makes: only where somebody looks, at most once in a second, and for
  /// at most a hundredth of the time.
  void landmarks(const std::function<std::vector<RunLandmark>()>& make);
  void smoothing();
  /// The run as it is written: viewers get what `chasles report` would show.
  void finish(const ReportRun& run, bool interrupted);
  void fail(const std::string& why);

  // The server's thread.

  void refresh(std::size_t viewers) override;
  LiveText next(LiveCursor& cursor) override;
  void stop() override {
    if (stop_) stop_();
  }

 private:
  using Clock = std::chrono::steady_clock;
  /// What the run's thread has told since the last refresh.
  struct Inbox {
    std::optional<LiveStart> start;
    std::vector<RunState> states;
    std::optional<std::vector<RunLandmark>> landmarks;
    std::optional<LiveProgress> progress;
    LiveText all;
  };

  void tell_progress(LiveStage stage);
  void reach(LiveStage stage);
  void take_start(LiveStart start);
  bool has_news(const LiveCursor& have, const LiveCursor& then) const;
  LiveText rows_text(const LiveCursor& have, const LiveCursor& then);

  const std::string id_;
  const std::function<void()> stop_;

  // The run's thread alone.
  LiveProgress told_;
  Clock::time_point began_ = Clock::now(), next_map_{};

  std::atomic<bool> watched_ = false;
  std::mutex mutex_;  ///< of the inbox
  Inbox inbox_;

  // The server's thread alone.
  bool started_ = false;
  Run run_;  ///< grows; its truth stands in comparison_
  std::string summary_;
  GrowingComparison comparison_;
  LiveProgress progress_;
  std::uint64_t landmarks_version_ = 0, progress_version_ = 1;
  LiveText all_;
  /// The last texts, for viewers that are equally far: each with what it leads from and to.
  std::vector<std::pair<std::string, LiveText>> texts_;
};

/// Runs that are finished: viewers get their page and nothing else.
class FinishedRuns final : public LiveFeed {
 public:
  /// Throws as run_page().
  explicit FinishedRuns(const std::vector<ReportRun>& runs);

  void refresh(std::size_t) override {}
  LiveText next(LiveCursor& cursor) override;
  void stop() override {}

 private:
  const std::string id_;
  const LiveText all_;
};

}  // namespace chasles
