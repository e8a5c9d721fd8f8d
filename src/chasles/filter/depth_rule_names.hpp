#pragma once

#include <span>
#include <string_view>

namespace chasles {

/// "constant", and the rules that the program has registered (depth_rule.hpp). Stays valid when
/// more are registered.
std::span<const std::string_view> depth_rule_names();

}  // namespace chasles
