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
#include <chasles/live/pace.hpp>
#include <chasles/report/report.hpp>

namespace chasles {

/// The data of a run before its first estimate.
struct LiveStart {
  std::string name;
  std::vector<std::string> extra_names;  ///< Run::extra_names
  Trajectory truth;                      ///< empty where unknown
  TruthPairing pairing = {};
  Trajectory dead_reckoning = {};  ///< empty where unknown
  /// The available part of summary.json (an object): chart, mode, settings, cameras, version.
  std::string summary;
  std::size_t frames = 0;  ///< number of frames of the recording; 0: unknown
};

/// What viewers get now and then: what the run has found so far.
struct LiveMap {
  std::vector<RunLandmark> landmarks;
  std::string known = "{}";  ///< entries of summary.json (an object): closures, place_in_map
  std::optional<MapSketch> prior_map = {};  ///< once its place is found; shown as it was then
};

/// The stage of a run. The names are those of the protocol.
enum class LiveStage {
  kWaiting,      ///< no estimate yet
  kRunning,      ///< processing frames
  kSmoothing,    ///< batch estimation after the last frame
  kFinished,     ///< complete
  kInterrupted,  ///< ended early, by a signal or a viewer; the results up to then are complete
  kFailed,       ///< ended with an error
};

/// The progress of a run.
struct LiveProgress {
  LiveStage stage = LiveStage::kWaiting;
  std::size_t frames = 0, of = 0;  ///< done, total; 0: unknown
  double recorded_seconds = 0;     ///< recorded time that the frames cover
  double wall_seconds = 0;         ///< processing time of the frames
  std::string message = {};        ///< why it failed
  bool stoppable = true;           ///< a viewer may stop it
};

/// A run that viewers follow while it goes on. The run's thread reports its progress: it never
/// waits for a viewer, copies a state under a short lock, and does not change the run. The server's
/// thread converts it to updates for the viewers.
class LiveRun final : public LiveFeed {
 public:
  /// `stop`: ends the run, called on the server's thread; empty: the run cannot be stopped.
  explicit LiveRun(std::function<void()> stop);

  // Called on the run's thread.

  void begin(LiveStart start);
  void add(const RunState& state);
  /// `frames` frames are done, which cover `recorded_seconds` of the recording.
  void progress(std::size_t frames, double recorded_seconds);
  /// Stores the map that `make` returns: only if there are viewers, at most once per second, and
  /// for at most a hundredth of the time.
  void map(const std::function<LiveMap()>& make);
  void smoothing();
  /// The final run: viewers receive what `chasles report` would show.
  void finish(const ReportRun& run, bool interrupted);
  void fail(const std::string& why);

  // Called on the server's thread.

  void refresh(std::size_t viewers) override;
  LiveText next(LiveCursor& cursor) override;
  void stop() override {
    if (stop_) stop_();
  }

 private:
  using Clock = std::chrono::steady_clock;
  /// What the run's thread has reported since the last refresh.
  struct Inbox {
    std::optional<LiveStart> start;
    std::vector<RunState> states;
    std::optional<LiveMap> map;
    std::optional<LiveProgress> progress;
    LiveText all;
  };

  void report_progress(LiveStage stage);
  void reach(LiveStage stage);
  void take_start(LiveStart start);
  bool has_news(const LiveCursor& have, const LiveCursor& then) const;
  LiveText rows_text(const LiveCursor& have, const LiveCursor& then);

  const std::string id_;
  const std::function<void()> stop_;

  // Used by the run's thread only.
  LiveProgress reported_;
  Clock::time_point start_time_ = Clock::now();
  Pace maps_ = map_pace();

  std::atomic<bool> watched_ = false;
  std::mutex mutex_;  ///< guards the inbox
  Inbox inbox_;

  // Used by the server's thread only.
  bool started_ = false;
  Run run_;  ///< grows; its truth is in comparison_
  std::string summary_;
  std::string known_ = "{}";  ///< of the last map
  GrowingComparison comparison_;
  LiveProgress progress_;
  std::uint64_t landmarks_version_ = 0, progress_version_ = 1;
  LiveText all_;
  /// The last texts, each with its start and end state, shared by viewers at the same position.
  std::vector<std::pair<std::string, LiveText>> texts_;
};

/// Finished runs: viewers receive their page and nothing else.
class FinishedRuns final : public LiveFeed {
 public:
  /// Throws as run_page() does.
  explicit FinishedRuns(const std::vector<ReportRun>& runs);

  void refresh(std::size_t) override {}
  LiveText next(LiveCursor& cursor) override;
  void stop() override {}

 private:
  const std::string id_;
  const LiveText all_;
};

}  // namespace chasles
