#include <set>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/yaml_map.hpp>

#include "settings_io.hpp"

namespace chasles::app {
namespace {

std::string place(const std::filesystem::path& file, const YAML::Mark& mark) {
  return fmt::format("{}:{}", file.string(), mark.line + 1);
}

YAML::Node load(const std::filesystem::path& file) {
  const std::string text = read_yaml_file(file);
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw UsageError(fmt::format("{}: not YAML: {}", place(file, error.mark), error.msg));
  }
}

}  // namespace

void set_from_file(const SettingList& settings, const std::filesystem::path& file) {
  const YAML::Node root = load(file);
  if (root.IsNull()) return;
  if (!root.IsMap()) {
    throw UsageError(fmt::format("{}: expected lines of `key: value`", place(file, root.Mark())));
  }
  std::set<std::string> seen;
  for (const auto& entry : root) {
    const std::string where = place(file, entry.first.Mark());
    if (!entry.first.IsScalar()) {
      throw UsageError(fmt::format("{}: found a key that is not a word", where));
    }
    const std::string key = entry.first.Scalar();
    if (!seen.insert(key).second)
      throw UsageError(fmt::format("{}: key '{}' is repeated", where, key));
    const bool one_value = entry.second.IsScalar() || entry.second.IsNull();
    // An unknown key is a more likely mistake than a list as its value, so it is reported first.
    set(settings, where, key,
        one_value ? entry.second.IsNull() ? "" : entry.second.Scalar() : "a list or a map");
  }
}

}  // namespace chasles::app
