#include "run_settings.hpp"

#include <utility>

#include "filter_options.hpp"

namespace chasles::app {

SettingList setting_list(VelocitySlamSettings& settings) {
  SettingCollector collector;
  for_each_setting(settings, collector);
  for (Setting& s : collector.settings) {
    s.low = 0;
    s.above_low = s.unit == "probability" || s.name.ends_with("pixel_sigma") ||
                  s.name.ends_with("disparity_sigma");
    if (s.unit == "probability") s.high = 1;
    limit_time_offset(s);
  }
  return collector.settings;
}

VelocityRunSettings settings_from(const SettingSources& sources) {
  VelocityRunSettings settings;
  SettingList list = setting_list(settings.filter);
  for (Setting& s : setting_list(settings.batch)) list.push_back(std::move(s));
  if (!sources.config.empty()) set_from_file(list, sources.config);
  for (const std::string& assignment : sources.sets) set(list, assignment);
  if (!sources.chart.empty()) set(list, "--chart", "chart", sources.chart);
  if (!sources.mode.empty()) set(list, "--mode", "mode", sources.mode);
  return settings;
}

}  // namespace chasles::app
