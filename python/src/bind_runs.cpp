#include <atomic>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <chasles/data/durable_file.hpp>
#include <chasles/data/run.hpp>
#include <chasles/data/utf8.hpp>
#include <chasles/error.hpp>
#include <chasles/report/report.hpp>

#include "arrays.hpp"
#include "map_output.hpp"
#include "module.hpp"
#include "output_folder.hpp"
#include "run_folder.hpp"
#include "run_job.hpp"

namespace chasles::python {
namespace {

using Eigen::Index;
using Json = nlohmann::ordered_json;

// A run in memory, of this process or read from a folder.
struct PythonRun {
  Run run;
  std::string summary;  ///< JSON
  std::vector<std::shared_ptr<const BatchTerms>> batch = {};
};

// True once Python has a signal pending whose handler raises, such as Ctrl-C. Python handles
// signals in its main thread alone.
class Signals {
 public:
  bool pending() {
    if (raised_) return true;
    const py::gil_scoped_acquire held;
    if (PyErr_CheckSignals() != 0) {
      error_ = std::make_unique<py::error_already_set>();
      raised_ = true;
    }
    return raised_;
  }
  void rethrow() {
    if (error_) throw py::error_already_set(*error_);
  }

 private:
  std::atomic<bool> raised_ = false;
  std::unique_ptr<py::error_already_set> error_;
};

app::RunCommandOptions options_of(const py::kwargs& arguments) {
  app::RunCommandOptions o;
  o.quiet = true;
  py::dict settings;
  for (const auto& [key, value] : arguments) {
    const auto name = key.cast<std::string>();
    if (name == "estimator") {
      o.estimator = value.cast<std::string>();
    } else if (name == "threads") {
      o.threads = value.cast<int>();
    } else if (name == "begin") {
      o.begin = value.cast<std::string>();
    } else if (name == "map") {
      o.map = value.cast<std::filesystem::path>();
    } else if (name == "save_map") {
      o.save_map = value.cast<std::filesystem::path>();
    } else if (name == "keep_images") {
      o.keep_images = value.cast<int>();
    } else if (name == "config") {
      o.settings.config = value.cast<std::filesystem::path>().string();
    } else if (name == "mode") {
      o.settings.mode = value.cast<std::string>();
    } else {
      settings[key] = value;
    }
  }
  if (o.threads < 1) {
    throw UsageError(fmt::format("threads: found {}, expected 1 or more", o.threads));
  }
  o.settings.sets = assignments(settings);
  o.settings.set_option = "setting";
  o.settings.estimator = estimator_choice(o.estimator);
  return o;
}

PythonRun run(const Recording& given, const py::kwargs& arguments) {
  const app::RunCommandOptions o = options_of(arguments);
  Signals signals;
  PythonRun result;
  {
    const py::gil_scoped_release released;
    const std::scoped_lock lock(estimation());
    Recording recording = given;
    const app::PlannedRun planned = app::plan_run(o, recording);
    app::check_map_output(app::map_target(o));
    app::LiveView none({}, [] {}, {});
    app::CompletedRun done = planned([&] { return signals.pending(); }, none);
    if (!done.result.report.interrupted) {
      if (!app::save_map(o, recording, *done.estimator)) {
        throw Error(ExitCode::kNotInitialised,
                    "save_map: the run has no landmark that could be recognised");
      }
      result = {.run = std::move(done.result.run),
                .summary = json_text(done.summary),
                .batch = done.estimator->batch_terms()};
    }
  }
  signals.rethrow();
  return result;
}

PythonRun read_run_folder(const std::filesystem::path& folder) {
  const py::gil_scoped_release released;
  ReportRun read = app::read_with_timing(folder);
  return {.run = std::move(read.run), .summary = std::move(read.summary)};
}

Rows covariance_columns(const std::vector<Matrix6d>& covariances) {
  Rows rows(static_cast<Index>(covariances.size()), 36);
  for (std::size_t i = 0; i < covariances.size(); ++i) {
    rows.row(static_cast<Index>(i)) = covariances[i].reshaped<Eigen::RowMajor>().transpose();
  }
  return rows;
}

py::dict states(const PythonRun& r) {
  const std::vector<RunState>& list = r.run.states;
  const auto n = static_cast<Index>(list.size());
  const auto extras = static_cast<Index>(r.run.extra_names.size());
  Trajectory path;
  std::vector<Matrix6d> covariances;
  Rows extra(n, extras), sigma(n, extras), nis(n, 1);
  Eigen::Matrix<std::int64_t, Eigen::Dynamic, Eigen::Dynamic> counts(n, 7);
  std::vector<std::string> health;
  for (Index i = 0; i < n; ++i) {
    const RunState& s = list[static_cast<std::size_t>(i)];
    path.push_back({.time = s.time, .pose = s.world_T_imu});
    covariances.push_back(s.pose_covariance);
    for (Index k = 0; k < extras; ++k) {
      extra(i, k) = s.extra[static_cast<std::size_t>(k)];
      sigma(i, k) = s.extra_sigma[static_cast<std::size_t>(k)];
    }
    nis(i, 0) = s.nis;
    counts.row(i) << s.nis_dof, s.observations, s.used, s.rejected, s.added, s.in_state,
        s.landmarks;
    health.push_back(s.health);
  }
  py::dict result = columns(path);
  result["pose_covariance"] = cubes(covariance_columns(covariances), 6);
  for (Index k = 0; k < extras; ++k) {
    const std::string& name = r.run.extra_names[static_cast<std::size_t>(k)];
    result[py::str(name)] = Eigen::VectorXd(extra.col(k));
    result[py::str(name + "_sigma")] = Eigen::VectorXd(sigma.col(k));
  }
  result["nis"] = Eigen::VectorXd(nis.col(0));
  Index k = 0;
  for (const char* name :
       {"nis_dof", "observations", "used", "rejected", "added", "in_state", "landmarks"}) {
    result[name] = Times(counts.col(k++));
  }
  result["health"] = std::move(health);
  return result;
}

py::dict poses(const std::vector<SmoothedPose>& list) {
  Trajectory path;
  std::vector<Matrix6d> covariances;
  for (const SmoothedPose& pose : list) {
    path.push_back({.time = pose.time, .pose = pose.world_T_imu});
    covariances.push_back(pose.pose_covariance);
  }
  py::dict result = columns(path);
  result["pose_covariance"] = cubes(covariance_columns(covariances), 6);
  return result;
}

void save(const PythonRun& r, const std::filesystem::path& folder) {
  const py::gil_scoped_release released;
  app::prepare_output(folder);
  write_run(r.run, Json::parse(r.summary), folder);
}

std::string page(const PythonRun& r) {
  const py::gil_scoped_release released;
  return run_page({{.run = r.run, .summary = r.summary}});
}

std::string page_of_all(const std::vector<std::pair<std::string, const PythonRun*>>& named) {
  const py::gil_scoped_release released;
  std::vector<ReportRun> runs;
  for (const auto& [name, r] : named) {
    runs.push_back({.run = r->run, .summary = r->summary, .label = name});
  }
  return run_page(runs);
}

}  // namespace

void bind_runs(py::module_& m) {
  py::class_<PythonRun>(m, "Run", "The results of a run.")
      .def_property_readonly("name", [](const PythonRun& r) { return r.run.name; })
      .def_property_readonly("_summary", [](const PythonRun& r) { return r.summary; })
      .def_property_readonly("_level", [](const PythonRun& r) { return is_level(r.run); })
      .def_property_readonly("states", &states)
      .def_property_readonly("smoothed", [](const PythonRun& r) { return poses(r.run.smoothed); })
      .def_property_readonly("in_map", [](const PythonRun& r) { return poses(r.run.in_map); })
      .def_property_readonly("landmarks",
                             [](const PythonRun& r) { return columns(r.run.landmarks); })
      .def_property_readonly("truth", [](const PythonRun& r) { return columns(r.run.truth); })
      .def_property_readonly("_batch", [](const PythonRun& r) { return problems_of(r.batch); })
      .def("save", &save, py::arg("folder"))
      .def("page", &page);
  m.def("run", &run, py::arg("recording"));
  m.def("page", &page_of_all, py::arg("runs"));
  m.def("read_run", &read_run_folder, py::arg("folder"));
}

}  // namespace chasles::python
