#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/base/settings.hpp>

namespace chasles {

/// One setting of a settings struct, which must outlive it. Serves --set, --config, --help and
/// summary.json.
struct Setting {
  /// A setting of an enum type, accessed by name; `limits` has the names.
  struct ChoiceRef {
    void* value;
    std::string_view (*name)(const void* value);
    void (*assign)(void* value, std::string_view known_name);
  };
  using Value = std::variant<std::string*, bool*, int*, std::uint64_t*, double*,
                             std::optional<double>*, ChoiceRef>;
  std::string name;
  Value value;
  std::string unit;  ///< of numbers; "choice": the help lists the names; may be empty
  std::string meaning;
  Limits limits;
};

using SettingList = std::vector<Setting>;

/// Visitor that collects the settings of a for_each_setting of the library.
class SettingCollector {
 public:
  template <typename Value>
  void operator()(const char* name, Value& value, const char* unit, const char* meaning,
                  const Limits& limits) {
    if constexpr (ChoiceEnum<Value>) {
      settings.push_back({name, choice(value), unit, meaning, limits::one_of(kChoiceNames<Value>)});
    } else {
      settings.push_back({name, &value, unit, meaning, limits});
    }
  }
  SettingList settings;

 private:
  template <ChoiceEnum E>
  static Setting::ChoiceRef choice(E& value) {
    return {.value = &value,
            .name = [](const void* of) { return name_of(*static_cast<const E*>(of)); },
            .assign = [](void* to,
                         std::string_view name) { *static_cast<E*>(to) = *choice_of<E>(name); }};
  }
};

/// Every setting of a struct, with this prefix.
template <typename SettingsType>
SettingList list_of(SettingsType& settings, std::string_view prefix = "") {
  SettingCollector collector;
  for_each_setting(settings, collector);
  for (Setting& s : collector.settings) s.name.insert(0, prefix);
  return std::move(collector.settings);
}

/// Sets one setting from text. Messages start with `where` ("--set", "FILE:LINE"). Throws
/// UsageError for an unknown key, with the nearest and all known keys, and for a value that is
/// malformed, not finite or out of range.
void set(const SettingList& settings, const std::string& where, const std::string& key,
         std::string_view value);

/// Sets one setting from `key=value`, the argument of --set.
void set(const SettingList& settings, const std::string& assignment);

/// The same, with the name of `option` in messages.
void assign(const SettingList& settings, const std::string& option, const std::string& assignment);

/// Sets the settings of a YAML file, a flat list of `key: value`. Throws InputError if the file
/// cannot be read, UsageError with file and line for invalid content.
void set_from_file(const SettingList& settings, const std::filesystem::path& file);

/// The value in the format of --set; "auto" for an empty optional.
std::string value_text(const Setting& setting);

/// Every setting by name; "auto" for an empty optional.
nlohmann::ordered_json to_json(const SettingList& settings);

/// Two lines per setting: the default with its unit or choices, and the meaning.
std::string help_text(const SettingList& settings);

}  // namespace chasles
