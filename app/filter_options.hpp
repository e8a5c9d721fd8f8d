#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/lab/trial.hpp>

#include "run_settings.hpp"

namespace CLI {
class App;
}

namespace chasles::app {

/// Which filters are compared.
struct FilterOptions {
  std::vector<std::string> charts, landmarks, inits;  ///< every one with every other
  std::vector<std::string> presets;                   ///< "paper", "default"
  std::vector<std::string> estimators;                ///< "filter", "batch": each with all of these
  std::vector<std::string> configs;                   ///< YAML files, a filter each
  std::vector<std::string> sets;                      ///< key=value, for all of them
};

void declare_filters(CLI::App& parser, FilterOptions& options);

/// The presets, the files, and the charts x landmark forms x beginnings, in this order; both
/// presets where nothing is asked for. Throws UsageError for what is not known or there twice.
std::vector<FilterVariant> filters_from(const FilterOptions& options);

/// Which filters there are is not a matter of --set, which is for all of them, and each is there
/// once. Throw UsageError.
void check_not_named(const std::string& assignment);
void check_names(const std::vector<FilterVariant>& filters);

/// All settings of a filter by name, with those of batch estimation where it is one.
nlohmann::ordered_json settings_json(const FilterVariant& filter);

}  // namespace chasles::app
