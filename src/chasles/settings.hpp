#pragma once

#include <concepts>
#include <type_traits>

namespace chasles {

/// The settings struct `Type`, const or not: the argument of its for_each_setting.
template <typename S, typename Type>
concept SettingsOf = std::same_as<std::remove_const_t<S>, Type>;

}  // namespace chasles
