#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

namespace chasles {

/// The settings struct `Type`, const or not: the argument of its for_each_setting.
template <typename S, typename Type>
concept SettingsOf = std::same_as<std::remove_const_t<S>, Type>;

/// Limits of a setting: a range for a number, the allowed names for a text (none: any text). No
/// limits apply to a bool, nor to an enum, which has its Choices.
struct Limits {
  double low = -std::numeric_limits<double>::infinity();  ///< smallest number allowed
  double high = std::numeric_limits<double>::infinity();  ///< largest one
  bool above_low = false;                                 ///< low itself is not allowed
  std::span<const std::string_view> names = {};

  /// False for NaN and infinities.
  constexpr bool contain(double number) const {
    using Number = std::numeric_limits<double>;
    return number >= Number::lowest() && number <= Number::max() && number >= low &&
           number <= high && !(above_low && number == low);
  }
};

namespace limits {

inline constexpr Limits kAny;
inline constexpr Limits kNonNegative{.low = 0};
inline constexpr Limits kPositive{.low = 0, .above_low = true};
inline constexpr Limits kProbability{.low = 0, .high = 1, .above_low = true};
inline constexpr Limits kClockOffset{.low = -0.5, .high = 0.5};  ///< [s]

constexpr Limits at_least(double low) { return {.low = low}; }
constexpr Limits from_to(double low, double high) { return {.low = low, .high = high}; }
constexpr Limits one_of(std::span<const std::string_view> names) { return {.names = names}; }

/// Limits of a field of a table that has a least and a most for every type.
template <typename Value>
constexpr Limits of(double least, double most) {
  if (std::same_as<Value, std::uint64_t>) return kNonNegative;
  return std::same_as<Value, int> || std::same_as<Value, double> ? from_to(least, most) : kAny;
}

}  // namespace limits

/// An enumerator and its name in files, on the command line and in messages.
template <typename E>
struct Choice {
  E value;
  std::string_view name;
};
template <typename E>
Choice(E, const char*) -> Choice<E>;

/// The choices of an enum that is a setting. Specialised beside the enum: `static constexpr
/// std::array list` of its Choice<E>, in the order of the help text.
template <typename E>
struct Choices;

template <typename E>
concept ChoiceEnum = std::is_enum_v<E> && requires {
  Choices<E>::list;
};

/// The names of an enum's choices.
template <ChoiceEnum E>
inline constexpr auto kChoiceNames = [] {
  std::array<std::string_view, Choices<E>::list.size()> names{};
  for (std::size_t i = 0; i < names.size(); ++i) names[i] = Choices<E>::list[i].name;
  return names;
}();

/// Empty for a value that is not among the choices.
template <ChoiceEnum E>
constexpr std::string_view name_of(E value) {
  for (const Choice<E>& choice : Choices<E>::list) {
    if (choice.value == value) return choice.name;
  }
  return {};
}

template <ChoiceEnum E>
constexpr std::optional<E> choice_of(std::string_view name) {
  for (const Choice<E>& choice : Choices<E>::list) {
    if (choice.name == name) return choice.value;
  }
  return std::nullopt;
}

}  // namespace chasles
