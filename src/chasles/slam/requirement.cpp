#include <algorithm>
#include <cstdio>
#include <utility>

#include <chasles/slam/requirement.hpp>

namespace chasles {
namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

std::string with_unit(double value, const std::string& unit) {
  return number(value) + (unit.empty() || unit == "%" ? unit : " " + unit);
}

}  // namespace

Requirement at_least(std::string name, double measured, double threshold, std::string unit) {
  return {.way = "",
          .name = std::move(name),
          .measured = measured,
          .threshold = threshold,
          .at_least = true,
          .unit = std::move(unit),
          .met = measured >= threshold};
}

Requirement at_most(std::string name, double measured, double threshold, std::string unit) {
  return {.way = "",
          .name = std::move(name),
          .measured = measured,
          .threshold = threshold,
          .at_least = false,
          .unit = std::move(unit),
          .met = measured <= threshold};
}

bool all_met(std::span<const Requirement> requirements) {
  return std::ranges::all_of(requirements, &Requirement::met);
}

std::string why_not_initialised(double seconds, std::span<const Requirement> requirements) {
  std::string text = "not initialised after " + number(seconds) + " s";
  const char* separator = ": ";
  std::string way;
  for (const Requirement& r : requirements) {
    if (r.met) continue;
    if (r.way != way) {
      text += (way.empty() ? ": " : "; ") + r.way;
      way = r.way;
      separator = ": ";
    }
    text += separator + r.name + " " + with_unit(r.measured, r.unit) +
            (r.at_least ? " of at least " : " of at most ") + with_unit(r.threshold, r.unit);
    separator = ", ";
  }
  return text;
}

}  // namespace chasles
