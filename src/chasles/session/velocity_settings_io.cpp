#include <utility>

#include <chasles/session/inertial_settings_io.hpp>
#include <chasles/session/velocity_settings_io.hpp>

namespace chasles {

SettingList setting_list(VelocitySlamSettings& settings) { return list_of(settings); }
SettingList setting_list(ReaderSettings& settings) { return list_of(settings, "reader."); }

VelocityCommandSettings velocity_run_settings_from(const SettingSources& sources) {
  VelocityCommandSettings settings;
  settings.estimator = sources.estimator;
  SettingList list = setting_list(settings.filter);
  for (Setting& s : setting_list(settings.batch)) list.push_back(std::move(s));
  for (Setting& s : setting_list(settings.reader)) list.push_back(std::move(s));
  if (!sources.config.empty()) set_from_file(list, sources.config);
  for (const std::string& assignment : sources.sets) assign(list, sources.set_option, assignment);
  if (!sources.chart.empty()) set(list, "--chart", "chart", sources.chart);
  if (!sources.mode.empty()) set(list, "--mode", "mode", sources.mode);
  validate(settings);
  return settings;
}

}  // namespace chasles
