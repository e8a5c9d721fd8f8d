#include <concepts>
#include <string_view>
#include <type_traits>

#include <fmt/format.h>

#include <chasles/error.hpp>
#include <chasles/lab/loops_settings.hpp>

namespace chasles {
namespace {

// A step turns by less than a quarter: the way between two steps is then that of a loop.
constexpr int kLeastStepsOfLoop = 4;

[[noreturn]] void refuse(std::string_view field, std::string_view found,
                         std::string_view expected) {
  throw UsageError(fmt::format("simulation setting {} = {}: expected {}", field, found, expected));
}

void check_range(std::string_view field, double value, double least, double most,
                 std::string_view unit) {
  // NaN fails both comparisons, so it is refused too.
  if (value >= least && value <= most) return;
  const std::string_view space = unit.empty() ? "" : " ";
  refuse(field, fmt::format("{}{}{}", value, space, unit),
         fmt::format("a number from {} to {}{}{}", least, most, space, unit));
}

}  // namespace

void validate(const LoopsSettings& settings) {
  for_each_range(settings, [](const char* field, const auto& value, double least, double most,
                              std::string_view unit) {
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (std::same_as<Value, int> || std::same_as<Value, double>) {
      check_range(field, static_cast<double>(value), least, most, unit);
    }
  });
  if (kLeastStepsOfLoop * settings.loops > settings.steps) {
    refuse("loops", fmt::format("{}", settings.loops),
           fmt::format("at least {} steps a loop, so at most {} in {} steps", kLeastStepsOfLoop,
                       settings.steps / kLeastStepsOfLoop, settings.steps));
  }
}

}  // namespace chasles
