#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/base/validate.hpp>

namespace chasles::test {

/// What validate() says; empty where it lets the settings pass.
template <typename Settings>
std::string complaint_about(const Settings& settings) {
  try {
    validate(settings);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

inline std::vector<double> outside(const Limits& limits) {
  std::vector<double> numbers;
  if (std::isfinite(limits.low)) numbers.push_back(limits.above_low ? limits.low : limits.low - 1);
  if (std::isfinite(limits.high)) numbers.push_back(limits.high + 1);
  return numbers;
}

inline std::vector<double> at_the_edge(const Limits& limits) {
  std::vector<double> numbers;
  if (std::isfinite(limits.low)) numbers.push_back(limits.above_low ? limits.low + 1 : limits.low);
  if (std::isfinite(limits.high)) numbers.push_back(limits.high);
  return numbers;
}

/// Values that a setting of that type may not have, and some that it may.
template <typename Value>
std::pair<std::vector<Value>, std::vector<Value>> bad_and_good(const Limits& limits) {
  std::vector<Value> bad, good;
  if constexpr (std::is_same_v<Value, std::string>) {
    if (!limits.names.empty()) bad = {"", "none of these", std::string(limits.names[0]) + "|"};
    for (const std::string_view name : limits.names) good.emplace_back(name);
  } else if constexpr (std::is_enum_v<Value>) {
    bad = {Value{-1}, Value{99}};
    for (const auto& choice : Choices<Value>::list) good.push_back(choice.value);
  } else if constexpr (!std::is_same_v<Value, bool> && std::is_signed_v<Value>) {
    for (const double number : outside(limits)) bad.push_back(static_cast<Value>(number));
    for (const double number : at_the_edge(limits)) good.push_back(static_cast<Value>(number));
    if constexpr (std::is_same_v<Value, double>) {
      using Number = std::numeric_limits<double>;
      bad.insert(bad.end(), {Number::quiet_NaN(), Number::infinity(), -Number::infinity()});
    }
  }
  return {bad, good};
}

/// Each of the fields in turn, with the others as they are by default, at what it may be and at
/// what it may not be: rejected by validate(), with name, value and what is expected.
template <typename Settings>
void expect_each_field_is_assessed(const std::string& prefix = "") {
  Settings settings;
  EXPECT_EQ(complaint_about(settings), "");
  for_each_setting(settings, [&](const std::string& name, auto& field, const std::string& unit,
                                 const char*, const Limits& limits) {
    using Field = std::remove_reference_t<decltype(field)>;
    using Value = std::conditional_t<std::is_same_v<Field, std::optional<double>>, double, Field>;
    const Field before = field;
    const auto [bad, good] = bad_and_good<Value>(limits);
    for (const Value& value : bad) {
      field = value;
      EXPECT_EQ(complaint_about(settings), prefix + name + ": found " + setting_text(value) +
                                               ", expected " + expected_text<Field>(limits, unit));
    }
    for (const Value& value : good) {
      field = value;
      EXPECT_NO_THROW(validate_fields(settings)) << name << " = " << setting_text(value);
    }
    field = before;
  });
}

template <typename E>
void expect_choices_round_trip() {
  std::set<std::string_view> names;
  for (const Choice<E>& choice : Choices<E>::list) {
    EXPECT_EQ(name_of(choice.value), choice.name);
    EXPECT_EQ(choice_of<E>(choice.name), choice.value);
    EXPECT_TRUE(names.insert(choice.name).second) << choice.name;
  }
  EXPECT_FALSE(choice_of<E>(""));
  EXPECT_FALSE(choice_of<E>("multiview"));
}

/// Each name is there once, has a meaning, its numbers limits, and its choices names of their own.
template <typename Settings>
void expect_each_field_is_described() {
  const Settings settings;
  std::set<std::string> names;
  for_each_setting(settings, [&](const std::string& name, const auto& field, const char*,
                                 const std::string& meaning, const Limits& limits) {
    using Value = std::remove_cvref_t<decltype(field)>;
    EXPECT_TRUE(names.insert(name).second) << name;
    EXPECT_FALSE(meaning.empty()) << name;
    if constexpr (std::is_enum_v<Value>) {
      expect_choices_round_trip<Value>();
    } else if constexpr (std::is_same_v<Value, int> || std::is_same_v<Value, double> ||
                         std::is_same_v<Value, std::optional<double>>) {
      EXPECT_TRUE(std::isfinite(limits.low)) << name;
      EXPECT_LT(limits.low, limits.high) << name;
    }
  });
}

}  // namespace chasles::test
