#pragma once

#include <utility>

#include <fmt/format.h>

#include <chasles/session/print_text.hpp>

namespace chasles::app {

/// `print("{}: {} frames\n", name, frames)`: as print_text().
template <typename... Values>
void print(fmt::format_string<Values...> format, Values&&... values) {
  print_text(fmt::format(format, std::forward<Values>(values)...));
}

/// As note_text().
template <typename... Values>
void note(fmt::format_string<Values...> format, Values&&... values) {
  note_text(fmt::format(format, std::forward<Values>(values)...));
}

}  // namespace chasles::app
