#include "settings_io.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <concepts>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <chasles/data/text_file.hpp>
#include <chasles/error.hpp>

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

std::string range_text(const Setting& s) {
  std::vector<std::string> parts;
  if (std::isfinite(s.low))
    parts.push_back(fmt::format("{} {}", s.above_low ? "above" : "not below", s.low));
  if (std::isfinite(s.high)) parts.push_back(fmt::format("not above {}", s.high));
  return parts.empty() ? "" : fmt::format(" {}", fmt::join(parts, " and "));
}

std::string unit_text(const Setting& s) {
  return s.unit.empty() || s.unit == "1" || s.unit == "bool" ? "" : fmt::format(" [{}]", s.unit);
}

std::string expected(const Setting& s) {
  struct Kind {
    const Setting& s;
    std::string operator()(std::string*) const {
      return s.choices.empty() ? "a text" : fmt::format("one of {}", fmt::join(s.choices, ", "));
    }
    std::string operator()(bool*) const { return "true or false"; }
    std::string operator()(int*) const { return "a whole number" + range_text(s) + unit_text(s); }
    std::string operator()(std::uint64_t*) const { return "a whole number not below 0"; }
    std::string operator()(double*) const {
      return "a finite number" + range_text(s) + unit_text(s);
    }
    std::string operator()(std::optional<double>*) const {
      return (*this)(static_cast<double*>(nullptr)) + ", or auto";
    }
  };
  return std::visit(Kind{s}, s.value);
}

// Puts the text into the setting's value; false where it is none of the expected.
struct Assign {
  const Setting& s;
  std::string_view text;

  bool in_range(double number) const {
    return std::isfinite(number) && number >= s.low && number <= s.high &&
           !(s.above_low && number == s.low);
  }
  template <typename Number>
  bool number(Number& value) const {
    const auto number = parsed<Number>(text);
    if (!number || !in_range(static_cast<double>(*number))) return false;
    value = *number;
    return true;
  }
  bool operator()(std::string* value) const {
    if (!s.choices.empty() && std::ranges::find(s.choices, text) == s.choices.end()) return false;
    *value = text;
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
  constexpr std::size_t kMost = 40;  // that anybody reads
  if (known.size() > kMost) return fmt::format("--help lists the {} keys", known.size());
  return fmt::format("known keys: {}", fmt::join(known, ", "));
}

}  // namespace

void SettingCollector::add(const char* name, Setting::Value value, std::string_view unit,
                           const char* meaning) {
  Setting& s = settings.emplace_back();
  s.name = name;
  s.value = value;
  s.meaning = meaning;
  if (!std::holds_alternative<std::string*>(value)) {
    s.unit = unit;
    return;
  }
  for (std::size_t begin = 0; begin < unit.size();) {
    const std::size_t end = std::min(unit.find('|', begin), unit.size());
    s.choices.emplace_back(unit.substr(begin, end - begin));
    begin = end + 1;
  }
}

void set(const SettingList& settings, const std::string& where, const std::string& key,
         std::string_view value) {
  const auto setting = std::ranges::find(settings, key, &Setting::name);
  if (setting == settings.end()) {
    const std::vector<std::string> known = names(settings);
    throw UsageError(fmt::format("{}: unknown key '{}'{} ({})", where, key,
                                 did_you_mean(key, known), known_keys(known)));
  }
  if (!std::visit(Assign{*setting, trimmed(value)}, setting->value)) {
    // An option that is named as its setting need not say it twice.
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
  const auto text = [](const auto* value) {
    if constexpr (std::same_as<decltype(value), const std::optional<double>*>) {
      return *value ? fmt::format("{}", **value) : std::string(kAuto);
    } else {
      return fmt::format("{}", *value);
    }
  };
  return std::visit(text, setting.value);
}

nlohmann::ordered_json to_json(const SettingList& settings) {
  using Json = nlohmann::ordered_json;
  const auto json = [](const auto* value) -> Json {
    if constexpr (std::same_as<decltype(value), const std::optional<double>*>) {
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
    const std::string unit =
        s.choices.empty() ? unit_text(s) : fmt::format(" {}", fmt::join(s.choices, "|"));
    text += unit.empty() ? fmt::format("  {}\n", assignment)
                         : fmt::format("  {:<40}{}\n", assignment, unit);
    text += fmt::format("      {}\n", s.meaning);
  }
  return text;
}

}  // namespace chasles::app
