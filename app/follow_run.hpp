#pragma once

#include <chrono>
#include <filesystem>

#include <chasles/live/live_run.hpp>

namespace chasles::app {

/// Tells a LiveRun what another process writes into a run folder (GrowingRun), until its end.
class FollowedRun {
 public:
  FollowedRun(std::filesystem::path folder, LiveRun& run);

  /// Looks into the folder when it is time: for at most a tenth of the time.
  void look();

 private:
  using Clock = std::chrono::steady_clock;
  void take(Run now);
  void end();

  std::filesystem::path folder_;
  LiveRun& run_;
  std::filesystem::file_time_type begun_;
  Clock::time_point next_ = Clock::now();
  std::size_t told_ = 0;  ///< states
  bool started_ = false, ended_ = false;
};

}  // namespace chasles::app
