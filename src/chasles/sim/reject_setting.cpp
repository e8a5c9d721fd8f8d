#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/sim/reject_setting.hpp>

namespace chasles {

void reject_setting(std::string_view field, std::string_view found, std::string_view expected) {
  throw UsageError(
      fmt::format("{}{} = {}: expected {}", kSimulationSetting, field, found, expected));
}

}  // namespace chasles
