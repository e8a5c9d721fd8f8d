#include "filter_options.hpp"

#include <algorithm>
#include <filesystem>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/report/study.hpp>

#include "inertial_settings_io.hpp"
#include "settings_io.hpp"

namespace chasles::app {
namespace {

constexpr const char* kPaper = "paper";
constexpr const char* kDefault = "default";

// Kleinert and Stilla's filters.
std::vector<FilterVariant> paper() {
  std::vector<FilterVariant> filters;
  for (const char* chart : {"standard", "left-se3", "right-se3"}) {
    FilterVariant filter{.name = fmt::format("{}-{}", kPaper, chart), .settings = {}};
    filter.settings.chart = chart;
    filter.settings.landmarks = LandmarkForm::kCartesian;
    filter.settings.init = LandmarkInit::kFixedDepth;
    filter.settings.nav_attitude = true;
    filter.settings.gate = 1;
    filters.push_back(std::move(filter));
  }
  return filters;
}

std::vector<FilterVariant> preset(const std::string& name) {
  if (name == kPaper) return paper();
  if (name == kDefault) return {{.name = kDefault, .settings = {}}};
  throw UsageError(fmt::format("--preset: found '{}', expected {} or {}", name, kPaper, kDefault));
}

FilterVariant from_file(const std::string& file) {
  FilterVariant filter{.name = valid_utf8(std::filesystem::path(file).stem().string()),
                       .settings = {}};
  set_from_file(setting_list(filter.settings), file);
  return filter;
}

std::vector<std::string> or_default(const std::vector<std::string>& given,
                                    std::string_view otherwise) {
  return given.empty() ? std::vector{std::string(otherwise)} : given;
}

std::vector<FilterVariant> product(const FilterOptions& o) {
  if (o.charts.empty() && o.landmarks.empty() && o.inits.empty()) return {};
  const InertialSlamSettings defaults;
  std::vector<FilterVariant> filters;
  for (const std::string& chart : or_default(o.charts, defaults.chart)) {
    for (const std::string& landmarks : or_default(o.landmarks, name_of(defaults.landmarks))) {
      for (const std::string& init : or_default(o.inits, name_of(defaults.init))) {
        FilterVariant filter{.name = fmt::format("{}+{}+{}", chart, landmarks, init),
                             .settings = {}};
        const SettingList list = setting_list(filter.settings);
        set(list, "--charts", "chart", chart);
        set(list, "--landmarks", "landmarks", landmarks);
        set(list, "--init", "init", init);
        filters.push_back(std::move(filter));
      }
    }
  }
  return filters;
}

template <typename Items>
void append(std::vector<FilterVariant>& filters, Items&& more) {
  for (auto& filter : more) filters.push_back(std::move(filter));
}

// The name appears in tables and in file names, next to the files of the truth and of the
// landmarks.
void check_name(const std::string& name) {
  const bool printable = std::ranges::none_of(
      name, [](char c) { return c == ',' || c == '"' || static_cast<unsigned char>(c) < 0x20; });
  const bool is_taken =
      name == "truth" || name == "landmarks_truth" || name.ends_with(kLandmarksFile);
  if (printable && !name.empty() && !is_taken) return;
  throw UsageError(
      fmt::format("--config: found a filter called '{}' after its file; expected a name without "
                  "commas and quotation marks, other than 'truth', 'landmarks_truth' and '…{}': "
                  "rename the file",
                  name, kLandmarksFile));
}

// Each filter with each estimator.
std::vector<FilterVariant> with_estimators(const std::vector<FilterVariant>& filters,
                                           const std::vector<std::string>& estimators) {
  std::vector<FilterVariant> all;
  for (const std::string& estimator : or_default(estimators, "filter")) {
    const EstimatorChoice one = estimator_choice(estimator, "--estimators");
    for (FilterVariant filter : filters) {
      if (one.is_batch()) filter.name += "+batch";
      if (one.is_window()) filter.name += fmt::format("+window{}", one.keyframes);
      filter.estimator = one;
      all.push_back(std::move(filter));
    }
  }
  return all;
}

// Applies a setting to the filters, or to batch estimation if one is selected.
void set_for_all(const std::string& assignment, std::vector<FilterVariant>& filters) {
  check_not_named(assignment);
  const bool of_batch = assignment.starts_with("batch.");
  bool used = false;
  for (FilterVariant& filter : filters) {
    if (of_batch && filter.estimator.is_filter()) continue;
    set(of_batch ? setting_list(filter.batch) : setting_list(filter.settings), assignment);
    used = true;
  }
  if (used) return;
  throw UsageError(fmt::format("--set: '{}' is for --estimators batch and window:N", assignment));
}

}  // namespace

void check_not_named(const std::string& assignment) {
  const std::string key = assignment.substr(0, assignment.find('='));
  if (key != "chart" && key != "landmarks" && key != "init") return;
  throw UsageError(
      fmt::format("--set: '{}' is for all filters alike; expected --charts, "
                  "--landmarks or --init to choose among them",
                  assignment));
}

void check_names(const std::vector<FilterVariant>& filters) {
  for (const FilterVariant& filter : filters) check_name(filter.name);
  for (auto filter = filters.begin(); filter != filters.end(); ++filter) {
    const auto again =
        std::ranges::find(std::next(filter), filters.end(), filter->name, &FilterVariant::name);
    if (again == filters.end()) continue;
    throw UsageError(fmt::format("the filter '{}' is there twice, expected once", filter->name));
  }
}

void declare_filters(CLI::App& parser, FilterOptions& o) {
  const auto add = [&](const char* name, std::vector<std::string>& values, const char* type,
                       const char* meaning) {
    return parser.add_option(name, values, meaning)->type_name(type)->group("Filters");
  };
  add("--preset", o.presets, "paper|default,...",
      "paper: the three filters of Kleinert and Stilla; default: the default settings "
      "(default: both)")
      ->delimiter(',');
  add("--charts", o.charts, "NAME,...",
      "Error charts, combined with all landmark forms and initialisations")
      ->delimiter(',');
  add("--landmarks", o.landmarks, "NAME,...", "Landmark forms: cartesian, inverse-depth")
      ->delimiter(',');
  add("--init", o.inits, "NAME,...", "Landmark initialisation: fixed-depth, multi-view")
      ->delimiter(',');
  add("--estimators", o.estimators, "filter|batch|window:N,...",
      "filter (default), batch, window:N: each with all filters; batch starts from the filter's "
      "estimate (docs/batch.md, docs/window.md)")
      ->delimiter(',');
  add("--config", o.configs, "FILE",
      "Add a filter with the settings of this YAML file and the file's name; may be repeated")
      ->allow_extra_args(false);
  add("--set", o.sets, "KEY=VALUE", "One setting, for every filter; may be repeated")
      ->allow_extra_args(false);
}

std::vector<FilterVariant> filters_from(const FilterOptions& o) {
  std::vector<FilterVariant> filters;
  for (const std::string& name : o.presets) append(filters, preset(name));
  for (const std::string& file : o.configs) filters.push_back(from_file(file));
  append(filters, product(o));
  if (filters.empty()) {
    for (const char* name : {kPaper, kDefault}) append(filters, preset(name));
  }
  filters = with_estimators(filters, o.estimators);
  for (const std::string& assignment : o.sets) set_for_all(assignment, filters);
  for (const FilterVariant& filter : filters) {
    validate(filter.settings);
    validate(filter.batch);
  }
  check_names(filters);
  return filters;
}

nlohmann::ordered_json settings_json(const FilterVariant& filter) {
  nlohmann::ordered_json all = settings_json(filter.settings);
  if (filter.estimator.is_filter()) return all;
  BatchSettings copy = filter.batch;
  all.update(to_json(setting_list(copy)));
  return all;
}

}  // namespace chasles::app
