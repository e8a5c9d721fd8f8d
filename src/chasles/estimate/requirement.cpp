#include <algorithm>
#include <cstdio>

#include <chasles/estimate/requirement.hpp>

namespace chasles {
namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

std::string with_unit(double value, std::string_view unit) {
  return number(value) + (unit.empty() || unit == "%" ? "" : " ") + std::string(unit);
}

}  // namespace

Requirement at_least(std::string_view name, double measured, double threshold,
                     std::string_view unit) {
  return {.way = "",
          .name = name,
          .measured = measured,
          .threshold = threshold,
          .at_least = true,
          .unit = unit,
          .met = measured >= threshold};
}

Requirement at_most(std::string_view name, double measured, double threshold,
                    std::string_view unit) {
  return {.way = "",
          .name = name,
          .measured = measured,
          .threshold = threshold,
          .at_least = false,
          .unit = unit,
          .met = measured <= threshold};
}

bool all_met(std::span<const Requirement> requirements) {
  return std::ranges::all_of(requirements, &Requirement::met);
}

std::string why_not_initialised(double seconds, std::span<const Requirement> requirements) {
  std::string text = "not initialised after " + number(seconds) + " s";
  const char* separator = ": ";
  std::string_view way;
  for (const Requirement& r : requirements) {
    if (r.met) continue;
    if (r.way != way) {
      text += (way.empty() ? ": " : "; ") + std::string(r.way);
      way = r.way;
      separator = ": ";
    }
    text += separator + std::string(r.name) + " " + with_unit(r.measured, r.unit) +
            (r.at_least ? " of at least " : " of at most ") + with_unit(r.threshold, r.unit);
    separator = ", ";
  }
  return text;
}

}  // namespace chasles
