#include "live_text.hpp"

#include <algorithm>
#include <cstdio>
#include <unistd.h>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/ioctl.h>

#include <chasles/codec/utf8.hpp>

namespace chasles::app {
namespace {

// Lines that wrap could not be written over.
std::size_t terminal_width() {
  constexpr std::size_t kUsual = 80;
  winsize size{};
  const bool is_known = ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
  return (is_known ? size.ws_col : kUsual) - 1;
}

void draw(const std::string& text) {
  // Not fmt::print, which throws where the terminal has gone.
  std::fputs(text.c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace

LiveText::LiveText(bool quiet) : quiet_(quiet), is_terminal_(::isatty(STDERR_FILENO) == 1) {}

LiveText::~LiveText() {
  if (shown_ > 0) draw("\n");
}

void LiveText::show(const std::vector<std::string>& lines) {
  if (quiet_) return;
  if (!is_terminal_) {
    const std::string text = printable(fmt::format("{}\n", fmt::join(lines, " | ")));
    if (text != last_) draw(text);
    last_ = text;
    return;
  }
  std::string text = shown_ > 1 ? fmt::format("\033[{}A", shown_ - 1) : "";
  const std::size_t count = std::max(shown_, lines.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::string line = i < lines.size() ? printable(lines[i]) : "";
    text += fmt::format("\r{:.{}}\033[K{}", line, terminal_width(), i + 1 < count ? "\n" : "");
  }
  shown_ = count;
  draw(text);
}

}  // namespace chasles::app
