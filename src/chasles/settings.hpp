#pragma once

#include <concepts>
#include <type_traits>

namespace chasles {

/// A settings struct of that type, const or not: what its for_each_setting takes.
template <typename S, typename Type>
concept SettingsOf = std::same_as<std::remove_const_t<S>, Type>;

}  // namespace chasles
