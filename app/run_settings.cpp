#include "run_settings.hpp"

namespace chasles::app {

SettingList setting_list(Settings& settings) {
  SettingCollector collector;
  for_each_setting(settings, collector);
  for (Setting& s : collector.settings) {
    s.low = 0;
    s.above_low = s.unit == "probability" || s.name.ends_with("pixel_sigma") ||
                  s.name.ends_with("disparity_sigma");
    if (s.unit == "probability") s.high = 1;
  }
  return collector.settings;
}

Settings settings_from(const SettingSources& sources) {
  Settings settings;
  const SettingList list = setting_list(settings);
  if (!sources.config.empty()) set_from_file(list, sources.config);
  for (const std::string& assignment : sources.sets) set(list, assignment);
  if (!sources.chart.empty()) set(list, "--chart", "chart", sources.chart);
  if (!sources.mode.empty()) set(list, "--mode", "mode", sources.mode);
  return settings;
}

}  // namespace chasles::app
