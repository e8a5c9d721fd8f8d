#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace chasles {

/// What a process may use. The bounds grow with the recording, because runs do.
struct ProcessBounds {
  double seconds_per_minute = 120;     ///< processor time for each minute of the recording [s]
  double megabytes_per_minute = 1500;  ///< memory that it does not share, for each minute [MB]

  /// Shorter recordings have the bounds of this length [min]; so has reading, before the length is
  /// known.
  static constexpr double kLeastMinutes = 2;
  /// A process that waits, for a file system that does not answer, ends after this many times the
  /// bound on processor time, by the clock.
  static constexpr double kClockFactor = 10;
};

/// How a process ended, and what it used.
struct EndedProcess {
  enum class How { kDone, kTime, kMemory, kDied };
  How how = How::kDone;
  std::string result;  ///< what the work returned, of kDone; else a sentence about the end
  int attempts = 1;    ///< of which all but the last died
  double wall_seconds = 0, cpu_seconds = 0;
  std::uint64_t peak_bytes = 0;  ///< largest resident memory
};

/// The work of a process: returns the result, and calls `minutes` when it knows the length of its
/// recording [min]. It may not throw.
using BoundedWork =
    std::function<std::string(std::size_t item, const std::function<void(double)>& minutes)>;

/// Executes work(item) for each item in a process of its own, at most `jobs` at a time, and passes
/// the end of each to done(item, end), in this process, as they end. A process that dies is tried
/// once more. The processes end with this one, however that ends. Returns false where stop()
/// returned true: the processes in progress are then killed. Throws InputError where the system
/// gives no process, and what `done` throws.
bool run_in_bounded_processes(std::span<const std::size_t> items, int jobs,
                              const ProcessBounds& bounds, const BoundedWork& work,
                              const std::function<void(std::size_t, const EndedProcess&)>& done,
                              const std::function<bool()>& stop);

}  // namespace chasles
