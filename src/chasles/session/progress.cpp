#include <algorithm>
#include <cstdio>
#include <unistd.h>

#include <fmt/format.h>

#include <chasles/session/progress.hpp>

namespace chasles {
namespace {

constexpr std::size_t kWidth = 30;
constexpr std::chrono::milliseconds kBetweenDraws{100};

}  // namespace

Progress::Progress(std::size_t frames, bool silent, const char* unit)
    : frames_(frames),
      unit_(unit),
      drawing_(!silent && frames > 0 && ::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

void Progress::show(std::size_t done, double recorded_seconds) {
  if (!drawing_ || Clock::now() < next_) return;
  const double wall = std::chrono::duration<double>(Clock::now() - start_).count();
  // Not fmt::print, which throws where the terminal has gone.
  const std::string text = progress_text(done, frames_, recorded_seconds, wall, unit_);
  std::fputs(fmt::format("\r{}\033[K", text).c_str(), stderr);
  std::fflush(stderr);
  drawn_ = true;
  next_ = Clock::now() + kBetweenDraws;
}

std::string progress_text(std::size_t done, std::size_t frames, double recorded_seconds,
                          double wall_seconds, const char* unit) {
  const std::size_t filled = std::min(kWidth, kWidth * done / std::max<std::size_t>(frames, 1));
  std::string bar(filled, '=');
  if (filled < kWidth) bar += '>' + std::string(kWidth - filled - 1, ' ');
  std::string text = fmt::format("[{}] {}/{} {}", bar, done, frames, unit);
  if (wall_seconds <= 0 || done == 0) return text;
  const double left = wall_seconds / static_cast<double>(done) * static_cast<double>(frames - done);
  if (recorded_seconds > 0) {
    text += fmt::format(", {:.0f} x real time", recorded_seconds / wall_seconds);
  }
  return text + (left < 120 ? fmt::format(", {:.1f} s left", left)
                            : fmt::format(", {:.0f} min left", left / 60));
}

}  // namespace chasles
