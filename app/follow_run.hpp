#pragma once

#include <chrono>
#include <filesystem>

#include <chasles/live/live_run.hpp>

namespace chasles::app {

/// Passes on to a LiveRun what another process writes into a run folder (GrowingRun), until that
/// run ends.
class FollowedRun {
 public:
  FollowedRun(std::filesystem::path folder, LiveRun& run);

  /// Reads new states from the folder if it is time to. Reading takes at most a tenth of the time.
  void poll();

 private:
  using Clock = std::chrono::steady_clock;
  void take(Run now);
  void end();

  std::filesystem::path folder_;
  LiveRun& run_;
  std::filesystem::file_time_type first_written_;
  Clock::time_point next_ = Clock::now();
  std::size_t shown_ = 0;  ///< number of states passed on
  bool started_ = false, ended_ = false;
};

}  // namespace chasles::app
