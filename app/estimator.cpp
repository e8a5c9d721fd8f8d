#include "estimator.hpp"

#include <charconv>

#include <fmt/format.h>

#include <chasles/error.hpp>

namespace chasles::app {

Estimator estimator_from(const std::string& option, const std::string& text) {
  const std::string window = "window:";
  if (text == "filter") return {};
  if (text == "batch") return {.batch = true};
  int keyframes = 0;
  if (text.starts_with(window)) {
    const char* end = text.data() + text.size();
    const auto read = std::from_chars(text.data() + window.size(), end, keyframes);
    if (read.ec == std::errc{} && read.ptr == end && keyframes >= 2) return {.window = keyframes};
  }
  throw UsageError(fmt::format(
      "{}: found '{}', expected filter, batch or window:N with N of 2 or more", option, text));
}

}  // namespace chasles::app
