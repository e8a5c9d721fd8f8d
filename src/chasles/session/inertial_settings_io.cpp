#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/session/inertial_settings_io.hpp>

namespace chasles {
namespace {

void append(SettingList more, SettingList& list) {
  for (Setting& setting : more) list.push_back(std::move(setting));
}

SettingList beside_the_filter(InertialRunSettings& settings) {
  SettingList list = list_of(settings.start, "start.");
  append(list_of(settings.frontend, "frontend."), list);
  append(setting_list(settings.batch), list);
  return list;
}

SettingList all_of(InertialRunSettings& settings) {
  SettingList list = setting_list(settings.filter);
  append(beside_the_filter(settings), list);
  return list;
}

}  // namespace

InertialRunSettings inertial_run_settings_from(const SettingSources& sources) {
  InertialRunSettings settings{.estimator = sources.estimator};
  const SettingList list = all_of(settings);
  if (!sources.config.empty()) set_from_file(list, sources.config);
  for (const std::string& assignment : sources.sets) assign(list, sources.set_option, assignment);
  if (!sources.chart.empty()) set(list, "--chart", "chart", sources.chart);
  validate(settings);
  return settings;
}

nlohmann::ordered_json settings_json(const InertialRunSettings& settings) {
  InertialRunSettings copy = settings;
  return to_json(all_of(copy));
}

InertialRunSettings inertial_run_settings_of(std::string_view summary) {
  InertialRunSettings settings;
  const SettingList list = all_of(settings);
  const auto json = nlohmann::json::parse(summary, nullptr, false);
  const auto stated = json.is_object() ? json.value("settings", nlohmann::json::object())
                                       : nlohmann::json::object();
  try {
    for (const Setting& setting : list) {
      const auto found = stated.find(setting.name);
      if (found == stated.end()) continue;
      set(list, "summary.json: settings", setting.name,
          found->is_string() ? found->get<std::string>() : found->dump());
    }
    validate(settings);
  } catch (const UsageError& error) {
    throw InputError(error.what());
  }
  return settings;
}

std::string inertial_run_settings_help() {
  InertialRunSettings defaults;
  return "Settings of the start, of the front end and of batch estimation:\n" +
         help_text(beside_the_filter(defaults));
}

std::string frontend_settings_help() {
  FrontendSettings defaults;
  return "Settings of the front end, for --set and --config:\n" +
         help_text(list_of(defaults, "frontend."));
}

SettingList setting_list(InertialSlamSettings& settings) { return list_of(settings); }
SettingList setting_list(BatchSettings& settings) { return list_of(settings, "batch."); }

nlohmann::ordered_json settings_json(const InertialSlamSettings& settings) {
  InertialSlamSettings copy = settings;
  return to_json(setting_list(copy));
}

std::string filter_settings_help() {
  InertialSlamSettings defaults;
  return "Settings of a filter, for --set and --config:\n" + help_text(setting_list(defaults));
}

}  // namespace chasles
