#include "progress.hpp"

#include <algorithm>
#include <cstdio>
#include <unistd.h>

#include <fmt/format.h>

namespace chasles::app {
namespace {

constexpr std::size_t kWidth = 30;
constexpr std::chrono::milliseconds kBetweenDraws{100};

}  // namespace

Progress::Progress(std::size_t frames, bool silent)
    : frames_(frames), drawing_(!silent && frames > 0 && ::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

void Progress::show(std::size_t done, double recorded_seconds) {
  if (!drawing_ || Clock::now() < next_) return;
  const double wall = std::chrono::duration<double>(Clock::now() - start_).count();
  fmt::print(stderr, "\r{}\033[K", progress_text(done, frames_, recorded_seconds, wall));
  std::fflush(stderr);
  drawn_ = true;
  next_ = Clock::now() + kBetweenDraws;
}

std::string progress_text(std::size_t done, std::size_t frames, double recorded_seconds,
                          double wall_seconds) {
  const std::size_t filled = std::min(kWidth, kWidth * done / std::max<std::size_t>(frames, 1));
  std::string bar(filled, '=');
  if (filled < kWidth) bar += '>' + std::string(kWidth - filled - 1, ' ');
  std::string text = fmt::format("[{}] {}/{} frames", bar, done, frames);
  if (wall_seconds <= 0 || done == 0) return text;
  const double left = wall_seconds / static_cast<double>(done) * static_cast<double>(frames - done);
  return text +
         fmt::format(", {:.0f} x real time, {:.1f} s left", recorded_seconds / wall_seconds, left);
}

}  // namespace chasles::app
