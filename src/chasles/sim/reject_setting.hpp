#pragma once

#include <string_view>

namespace chasles {

/// Before the name of a setting in messages.
inline constexpr const char* kSimulationSetting = "simulation setting ";

/// Throws UsageError: "simulation setting FIELD = FOUND: expected EXPECTED".
[[noreturn]] void reject_setting(std::string_view field, std::string_view found,
                                 std::string_view expected);

}  // namespace chasles
