#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/run_folder/run.hpp>

namespace chasles {

/// Entry of a growing run's summary.json: as many bytes of states.csv are complete rows.
inline constexpr const char* kStatesBytes = "states_bytes";

/// The folder `growing` inside a run folder while the run goes on. It is itself a run folder with
/// the estimates so far, for readers of a running run and in case the run is killed or its results
/// cannot be written. It is locked (flock) during the run and removed after its end.
class GrowingRun {
 public:
  struct Pace {
    std::chrono::milliseconds first{2000};    ///< shorter runs write nothing
    std::chrono::milliseconds between{1000};  ///< minimum time between two writes
    int share = 100;                          ///< writing takes at most 1/share of the time
  };

  /// Creates and locks the folder. Removes the files of a killed run, and nothing else. Throws
  /// UsageError if another run writes into the folder, or if it cannot be written.
  explicit GrowingRun(const std::filesystem::path& run_folder);
  GrowingRun(const std::filesystem::path& run_folder, Pace pace);
  GrowingRun(const GrowingRun&) = delete;
  GrowingRun& operator=(const GrowingRun&) = delete;
  ~GrowingRun();  ///< removes the folder after end(), or if it is not readable yet

  /// `header`: the run before its first state. `summary`: the entries of summary.json that are
  /// already available.
  void begin(const Run& header, const nlohmann::ordered_json& summary);
  /// If a write is due: appends the new states and writes the map that `map` returns. After a
  /// failed write nothing more is written, so that the run itself continues.
  void extend(const Run& run, const std::function<std::vector<RunLandmark>()>& map);
  /// The results are in the run folder: nobody needs these files any more.
  void end();

 private:
  using Clock = std::chrono::steady_clock;
  void write(const Run& run, const std::vector<RunLandmark>& landmarks);
  void remove_files() const;

  std::filesystem::path folder_;
  Pace pace_;
  int lock_ = -1;  ///< file descriptor
  Clock::time_point next_;
  std::unique_ptr<nlohmann::ordered_json> summary_;
  std::size_t written_ = 0, bytes_ = 0;  ///< states, and their text
  bool readable_ = false, given_up_ = false;
};

/// The path of a run folder's growing run.
std::filesystem::path growing_folder(const std::filesystem::path& run_folder);

/// Whether a run is writing into the run folder.
bool is_growing(const std::filesystem::path& run_folder);

}  // namespace chasles
