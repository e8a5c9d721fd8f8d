#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace chasles {

/// Progress bar on stderr: frames done, speed relative to real time, remaining time. Draws nothing
/// if stderr is not a terminal.
class Progress {
 public:
  /// `silent`: draw nothing; `unit`: name of the counted items.
  Progress(std::size_t frames, bool silent, const char* unit = "frames");
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();  ///< clears the bar

  /// Draws the bar for `done` frames that cover `recorded_seconds` [s]; with 0 it shows no speed.
  void show(std::size_t done, double recorded_seconds = 0);

 private:
  using Clock = std::chrono::steady_clock;
  std::size_t frames_;
  const char* unit_;
  bool drawing_;
  bool drawn_ = false;
  Clock::time_point start_ = Clock::now();
  Clock::time_point next_ = start_;
};

/// Text of the bar: "[=====>    ]  532/1106 frames, 104 x real time, 0.6 s left"; from two minutes
/// on "12 min left".
std::string progress_text(std::size_t done, std::size_t frames, double recorded_seconds,
                          double wall_seconds, const char* unit = "frames");

}  // namespace chasles
