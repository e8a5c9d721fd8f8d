#include "loops_options.hpp"

#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/filter/charts/error_chart.hpp>

#include "settings_io.hpp"

namespace chasles::app {
namespace {

constexpr const char* kLoops = "loops";

// The settings of a filter that have an effect without cameras and IMU.
SettingList chart_settings(InertialSlamSettings& settings) {
  SettingList list = list_of(settings);
  std::erase_if(list, [](const Setting& setting) {
    return setting.name != "chart" && setting.name != "first_estimates";
  });
  return list;
}

void check(const FilterOptions& o) {
  if (!o.presets.empty()) {
    throw UsageError(
        "--preset: the presets are filters for an IMU and cameras; the scene loops has neither: "
        "expected --charts or --config");
  }
  if (!o.estimators.empty()) {
    throw UsageError("--estimators is for an IMU and cameras; the scene loops has neither");
  }
  if (!o.landmarks.empty() || !o.inits.empty()) {
    throw UsageError(
        "--landmarks and --init are for cameras; the scene loops measures points and initialises a "
        "landmark at the first observation: expected --charts or --config");
  }
}

FilterVariant loops_from_file(const std::string& file) {
  FilterVariant filter{.name = valid_utf8(std::filesystem::path(file).stem().string()),
                       .settings = {}};
  set_from_file(chart_settings(filter.settings), file);
  return filter;
}

FilterVariant with_chart(const std::string& chart) {
  FilterVariant filter{.name = chart, .settings = {}};
  set(chart_settings(filter.settings), "--charts", "chart", chart);
  return filter;
}

std::vector<std::string> all_charts() {
  std::vector<std::string> names;
  for (const ErrorChart& chart : error_charts()) names.emplace_back(chart.name);
  return names;
}

}  // namespace

bool is_loops(const std::string& name) { return name == kLoops; }

LoopsSettings loops_from(const SceneChoice& choice) {
  reject_path(choice);
  LoopsSettings settings;
  const SettingList list = list_of(settings);
  if (!choice.config.empty()) set_from_file(list, choice.config);
  for (const std::string& assignment : choice.sets) assign(list, choice.set_option, assignment);
  if (!choice.seed.empty()) set(list, "--seed", "seed", choice.seed);
  validate(settings);
  return settings;
}

std::vector<FilterVariant> loops_filters_from(const FilterOptions& o) {
  check(o);
  std::vector<FilterVariant> filters;
  for (const std::string& file : o.configs) filters.push_back(loops_from_file(file));
  const bool nothing = o.configs.empty() && o.charts.empty();
  for (const std::string& chart : nothing ? all_charts() : o.charts) {
    filters.push_back(with_chart(chart));
  }
  for (const std::string& assignment : o.sets) {
    check_not_named(assignment);
    for (FilterVariant& filter : filters) set(chart_settings(filter.settings), assignment);
  }
  check_names(filters);
  return filters;
}

std::string loops_scene_help() {
  return fmt::format("  {:<14} {}\n", kLoops,
                     "odometry and points in eight loops, as Zhang et al. 2017; no IMU, no camera");
}

std::string loops_settings_help() {
  LoopsSettings defaults;
  return help_text(list_of(defaults));
}

nlohmann::ordered_json settings_json(const LoopsSettings& settings) {
  LoopsSettings copy = settings;
  return to_json(list_of(copy));
}

nlohmann::ordered_json loops_settings_json(const InertialSlamSettings& settings) {
  InertialSlamSettings copy = settings;
  return to_json(chart_settings(copy));
}

}  // namespace chasles::app
