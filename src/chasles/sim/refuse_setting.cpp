#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/sim/refuse_setting.hpp>

namespace chasles {

void refuse_setting(std::string_view field, std::string_view found, std::string_view expected) {
  throw UsageError(
      fmt::format("{}{} = {}: expected {}", kSimulationSetting, field, found, expected));
}

}  // namespace chasles
