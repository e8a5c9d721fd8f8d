#pragma once

#include <ctime>

namespace chasles {

/// The time of a POSIX clock [s].
inline double clock_seconds(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Processor time of this thread so far [s].
inline double processor_seconds() { return clock_seconds(CLOCK_THREAD_CPUTIME_ID); }

/// Processor time of all threads of this process so far [s].
inline double process_seconds() { return clock_seconds(CLOCK_PROCESS_CPUTIME_ID); }

}  // namespace chasles
