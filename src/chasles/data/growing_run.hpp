#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/data/run.hpp>

namespace chasles {

/// The folder `growing` inside a run folder, while the run goes on: itself a run folder, of what
/// has been estimated so far, for those who look on and for the case that the run is killed. It is
/// locked (flock) as long as the run goes on, and removed at its end.
class GrowingRun {
 public:
  struct Pace {
    std::chrono::milliseconds first{2000};    ///< nothing is written of a run that is over before
    std::chrono::milliseconds between{1000};  ///< from one writing to the next, at least
    int share = 100;  ///< writing takes at most one part in so many of the time
  };

  /// Makes and locks it; what a killed run has left there is removed, nothing else. Throws
  /// UsageError where another run is writing into the folder, or where it cannot be written.
  explicit GrowingRun(const std::filesystem::path& run_folder);
  GrowingRun(const std::filesystem::path& run_folder, Pace pace);
  GrowingRun(const GrowingRun&) = delete;
  GrowingRun& operator=(const GrowingRun&) = delete;
  ~GrowingRun();  ///< removes it

  /// `header`: the run before its first state. `summary`: what is known of summary.json.
  void begin(const Run& header, const nlohmann::ordered_json& summary);
  /// Writes those of the run's states that are new, and the map that `map` makes, when it is time.
  /// Where that fails nothing more is written: the run is worth more.
  void extend(const Run& run, const std::function<std::vector<RunLandmark>()>& map);

 private:
  using Clock = std::chrono::steady_clock;
  void write(const Run& run, const std::vector<RunLandmark>& landmarks);
  void remove_files() const;

  std::filesystem::path folder_;
  Pace pace_;
  int lock_ = -1;  ///< file descriptor
  Clock::time_point next_;
  std::string summary_;
  std::size_t written_ = 0;  ///< states
  bool given_up_ = false;
};

/// Where a run folder's growing run is.
std::filesystem::path growing_folder(const std::filesystem::path& run_folder);

/// Whether a run is writing into the run folder.
bool is_growing(const std::filesystem::path& run_folder);

}  // namespace chasles
