#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/filter/charts/error_chart.hpp>
#include <chasles/filter/depth_rule_names.hpp>
#include <chasles/lab/monte_carlo.hpp>
#include <chasles/report/study.hpp>
#include <chasles/session/inertial_settings_io.hpp>
#include <chasles/session/settings_io.hpp>

#include "arrays.hpp"
#include "filter_options.hpp"
#include "interpreter_exit.hpp"
#include "lab.hpp"
#include "lab_report.hpp"
#include "long_call.hpp"
#include "messages.hpp"
#include "scene_options.hpp"
#include "trial_log.hpp"

// Studies: the same runs of a scene through several filters.
namespace chasles::python {
namespace {

FilterVariant variant_of(const std::string& name, py::dict settings) {
  check_keys("monte_carlo: " + name, settings, {"estimator"});
  FilterVariant filter{.name = name, .settings = {}};
  py::dict others;
  for (const auto& [key, value] : settings) {
    if (py::str(key).cast<std::string>() == "estimator") {
      filter.estimator = estimator_choice(as<std::string>(value, "estimator: found", "a str"));
    } else {
      others[key] = value;
    }
  }
  for (const std::string& one : assignments(others)) {
    const bool of_batch = one.starts_with("batch.");
    assign(of_batch ? setting_list(filter.batch) : setting_list(filter.settings), "setting", one);
  }
  validate(filter.settings);
  validate(filter.batch);
  return filter;
}

std::vector<FilterVariant> variants_of(const py::dict& filters) {
  std::vector<FilterVariant> all;
  for (const auto& [name, settings] : filters) {
    all.push_back(variant_of(as<std::string>(name, "filters: found the name", "a str"),
                             settings.cast<py::dict>()));
  }
  if (all.empty()) throw UsageError("filters: found none, expected {name: {setting: value}}");
  app::check_names(all);
  return all;
}

// Worker processes are forks of this one, in which Python cannot run.
void check_workers(const std::vector<FilterVariant>& filters, int workers) {
  if (workers < 1) throw UsageError("workers: expected a whole number above 0");
  if (workers == 1) return;
  const auto charts = error_charts();
  for (const FilterVariant& filter : filters) {
    const bool own_chart =
        std::ranges::find(charts, filter.settings.chart, &ErrorChart::name) == charts.end();
    if (!own_chart && filter.settings.depth_rule == depth_rule_names().front()) continue;
    throw UsageError("workers: found " + std::to_string(workers) + ", expected 1, as the filter '" +
                     filter.name + "' has a chart or a depth rule of this process");
  }
}

// The summary of a study that is complete, with its tables.
std::string finished(app::TrialLog& log) {
  const std::vector<FilterSummary> summaries = log.finish();
  nlohmann::ordered_json result = log.summary();
  result["table"] = app::tables(summaries, {}, app::TableStyle::kText);
  return json_text(result, 0);
}

std::string merge_studies(const std::vector<std::filesystem::path>& folders,
                          const std::filesystem::path& folder) {
  const Released released;
  app::TrialLog log = app::TrialLog::merged(folders, folder);
  return finished(log);
}

std::string monte_carlo(const std::string& scene, const py::dict& filters, std::uint64_t runs,
                        std::uint64_t first, int workers, const std::filesystem::path& folder,
                        const py::dict& scene_settings, const py::object& progress) {
  MonteCarloPlan plan{.scene = {}, .filters = variants_of(filters), .runs = {}};
  check_workers(plan.filters, workers);
  if (runs == 0) throw UsageError("runs: expected a whole number above 0");
  for (std::uint64_t i = 0; i < runs; ++i) plan.runs.push_back(first + i);
  check_scene_keys("monte_carlo", scene, scene_settings);
  app::SceneChoice choice;
  choice.name = scene;
  choice.sets = assignments(scene_settings);
  choice.set_option = "setting";
  LongCall call(progress);
  std::size_t done = 0;
  return call.in_turn([&] {
    plan.scene = app::scene_from(choice);
    app::TrialLog log(folder, app::plan_json(plan.scene, plan.filters), plan.runs, false);
    run_monte_carlo(plan, workers, [&](std::span<const TrialRecord> records) {
      std::string lines;
      for (const TrialRecord& record : records) lines += app::to_line(record);
      log.add(records.front().run, lines);
      call.show(++done, plan.runs.size());
    });
    return finished(log);
  });
}

std::string page_of_study(const std::filesystem::path& folder) {
  const Released released;
  return study_page({read_study(folder)});
}

}  // namespace

void bind_studies(py::module_& m) {
  m.def("monte_carlo", &monte_carlo, py::arg("scene"), py::arg("filters"), py::arg("runs"),
        py::arg("first"), py::arg("workers"), py::arg("folder"), py::arg("scene_settings"),
        py::arg("progress"));
  m.def("merge_studies", &merge_studies, py::arg("folders"), py::arg("folder"));
  m.def("study_page", &page_of_study, py::arg("folder"));
}

}  // namespace chasles::python
