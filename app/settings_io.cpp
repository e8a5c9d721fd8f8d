#include "settings_io.hpp"

#include <algorithm>
#include <charconv>
#include <concepts>
#include <type_traits>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/base/validate.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles::app {
namespace {

constexpr std::string_view kAuto = "auto";

template <typename Number>
std::optional<Number> parsed(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  Number number{};
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, number);
  if (text.empty() || error != std::errc{} || rest != end) return std::nullopt;
  return number;
}

// Unit or names of a setting for the help text.
std::string unit_text(const Setting& s) {
  if (s.unit == "choice") return fmt::format(" {}", fmt::join(s.limits.names, "|"));
  return s.unit.empty() || s.unit == "1" || s.unit == "bool" ? "" : fmt::format(" [{}]", s.unit);
}

std::string expected(const Setting& s) {
  const auto text = [&](const auto& value) {
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (std::same_as<Value, Setting::ChoiceRef>) {
      return one_of_text(s.limits.names);
    } else {
      return expected_text<std::remove_pointer_t<Value>>(s.limits, s.unit);
    }
  };
  return std::visit(text, s.value);
}

// Parses the text into the setting's value; false if it is invalid.
struct Assign {
  const Setting& s;
  std::string_view text;

  template <typename Number>
  bool number(Number& value) const {
    const auto number = parsed<Number>(text);
    if (!number || !is_allowed(*number, s.limits)) return false;
    value = *number;
    return true;
  }
  bool operator()(std::string* value) const {
    if (!is_allowed(text, s.limits)) return false;
    *value = text;
    return true;
  }
  bool operator()(const Setting::ChoiceRef& choice) const {
    if (!is_allowed(text, s.limits)) return false;
    choice.assign(choice.value, text);
    return true;
  }
  bool operator()(bool* value) const {
    if (text != "true" && text != "false") return false;
    *value = text == "true";
    return true;
  }
  bool operator()(int* value) const { return number(*value); }
  bool operator()(std::uint64_t* value) const { return number(*value); }
  bool operator()(double* value) const { return number(*value); }
  bool operator()(std::optional<double>* value) const {
    if (text == kAuto) {
      value->reset();
      return true;
    }
    double given = 0;
    if (!number(given)) return false;
    *value = given;
    return true;
  }
};

std::vector<std::string> names(const SettingList& settings) {
  std::vector<std::string> result;
  for (const Setting& s : settings) result.push_back(s.name);
  return result;
}

std::string known_keys(const std::vector<std::string>& known) {
  constexpr std::size_t kMost = 40;  // longest list that is useful
  if (known.size() > kMost) return fmt::format("--help lists the {} keys", known.size());
  return fmt::format("known keys: {}", fmt::join(known, ", "));
}

}  // namespace

void set(const SettingList& settings, const std::string& where, const std::string& key,
         std::string_view value) {
  const auto setting = std::ranges::find(settings, key, &Setting::name);
  if (setting == settings.end()) {
    const std::vector<std::string> known = names(settings);
    throw UsageError(fmt::format("{}: unknown key '{}'{} ({})", where, key,
                                 did_you_mean(key, known), known_keys(known)));
  }
  if (!std::visit(Assign{*setting, trimmed(value)}, setting->value)) {
    // An option with the name of its setting names it only once.
    const std::string place = where == "--" + key ? where : fmt::format("{}: {}", where, key);
    throw UsageError(fmt::format("{}: found '{}', expected {}", place, value, expected(*setting)));
  }
}

void set(const SettingList& settings, const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw UsageError(fmt::format("--set: found '{}', expected key=value", assignment));
  }
  set(settings, "--set", std::string(trimmed(assignment.substr(0, equals))),
      std::string_view(assignment).substr(equals + 1));
}

std::string value_text(const Setting& setting) {
  const auto text = [](const auto& value) {
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (std::same_as<Value, Setting::ChoiceRef>) {
      return std::string(value.name(value.value));
    } else if constexpr (std::same_as<Value, std::optional<double>*>) {
      return *value ? fmt::format("{}", **value) : std::string(kAuto);
    } else {
      return fmt::format("{}", *value);
    }
  };
  return std::visit(text, setting.value);
}

nlohmann::ordered_json to_json(const SettingList& settings) {
  using Json = nlohmann::ordered_json;
  const auto json = [](const auto& value) -> Json {
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (std::same_as<Value, Setting::ChoiceRef>) {
      return value.name(value.value);
    } else if constexpr (std::same_as<Value, std::optional<double>*>) {
      return *value ? Json(**value) : Json(kAuto);
    } else {
      return *value;
    }
  };
  Json all = Json::object();
  for (const Setting& s : settings) all[s.name] = std::visit(json, s.value);
  return all;
}

std::string help_text(const SettingList& settings) {
  std::string text;
  for (const Setting& s : settings) {
    const std::string assignment = fmt::format("{} = {}", s.name, value_text(s));
    const std::string unit = unit_text(s);
    text += unit.empty() ? fmt::format("  {}\n", assignment)
                         : fmt::format("  {:<40}{}\n", assignment, unit);
    text += fmt::format("      {}\n", s.meaning);
  }
  return text;
}

}  // namespace chasles::app
