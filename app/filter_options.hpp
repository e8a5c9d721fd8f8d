#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/lab/trial.hpp>
#include <chasles/session/velocity_settings_io.hpp>

namespace CLI {
class App;
}

namespace chasles::app {

/// Selection of the filters to compare.
struct FilterOptions {
  std::vector<std::string> charts, landmarks, inits;  ///< all combinations
  std::vector<std::string> presets;                   ///< "paper", "default"
  std::vector<std::string> estimators;                ///< "filter", "batch": each with all filters
  std::vector<std::string> configs;                   ///< YAML files, one filter each
  std::vector<std::string> sets;                      ///< key=value, for all of them
};

void declare_filters(CLI::App& parser, FilterOptions& options);

/// The filters in this order: presets, files, all combinations of charts, landmark forms and
/// landmark initialisations. Without any of these: both presets. Throws UsageError for an unknown
/// name and for a repeated filter.
std::vector<FilterVariant> filters_from(const FilterOptions& options);

/// Throws UsageError if a --set changes `chart`, `landmarks` or `init`, which select the filters.
void check_not_named(const std::string& assignment);
/// Throws UsageError if two filters have the same name.
void check_names(const std::vector<FilterVariant>& filters);

/// All settings of a filter by name; with the settings of batch estimation if it is one.
nlohmann::ordered_json settings_json(const FilterVariant& filter);

}  // namespace chasles::app
