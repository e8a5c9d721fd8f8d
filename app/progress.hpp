#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace chasles::app {

/// A bar on stderr while a recording is worked through: frames done, speed against real time, time
/// that remains. Draws nothing where stderr is no terminal.
class Progress {
 public:
  /// `silent`: draws nothing at all; `unit`: what is counted.
  Progress(std::size_t frames, bool silent, const char* unit = "frames");
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();  ///< wipes the bar

  /// That many frames are done, which cover that many seconds of the recording; 0: no speed is
  /// told.
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

/// The bar's text: "[=====>    ]  532/1106 frames, 104 x real time, 0.6 s left"; from two
/// minutes on "12 min left".
std::string progress_text(std::size_t done, std::size_t frames, double recorded_seconds,
                          double wall_seconds, const char* unit = "frames");

}  // namespace chasles::app
