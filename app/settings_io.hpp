#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace chasles::app {

/// One setting of some settings struct, which must outlive it: what --set, --config, --help and
/// summary.json need to know of it.
struct Setting {
  using Value =
      std::variant<std::string*, bool*, int*, std::uint64_t*, double*, std::optional<double>*>;
  std::string name;
  Value value;
  std::string unit;                  ///< for numbers; may be empty
  std::vector<std::string> choices;  ///< for text; empty: any text
  std::string meaning;
  double low = -std::numeric_limits<double>::infinity();  ///< smallest number allowed
  double high = std::numeric_limits<double>::infinity();  ///< largest one
  bool above_low = false;                                 ///< low itself is not allowed
};

using SettingList = std::vector<Setting>;

/// Of all settings that one is from -0.5 s to 0.5 s.
inline void limit_time_offset(Setting& setting) {
  if (setting.name != "time_offset") return;
  setting.low = -0.5;
  setting.high = 0.5;
}

/// The settings that a for_each function of the library visits: visit(name, value, unit or
/// choices separated by |, meaning).
class SettingCollector {
 public:
  template <typename Value>
  void operator()(const char* name, Value& value, std::string_view unit, const char* meaning) {
    add(name, Setting::Value(&value), unit, meaning);
  }
  SettingList settings;

 private:
  void add(const char* name, Setting::Value value, std::string_view unit, const char* meaning);
};

/// Sets one setting from text. `where` begins the messages ("--set", "FILE:LINE"). Throws
/// UsageError for an unknown key, naming the nearest and all known ones, and for a value that is
/// malformed, not finite or out of range.
void set(const SettingList& settings, const std::string& where, const std::string& key,
         std::string_view value);

/// Sets one setting from `key=value`, the argument of --set.
void set(const SettingList& settings, const std::string& assignment);

/// Sets what a YAML file says: a flat list of `key: value`. Throws InputError where the file cannot
/// be read, UsageError with file and line for everything in it that cannot be used.
void set_from_file(const SettingList& settings, const std::filesystem::path& file);

/// The value as --set takes it; "auto" for an empty optional.
std::string value_text(const Setting& setting);

/// Every setting by name. An empty optional is "auto".
nlohmann::ordered_json to_json(const SettingList& settings);

/// Two lines a setting: default with unit or choices, and the meaning.
std::string help_text(const SettingList& settings);

}  // namespace chasles::app
