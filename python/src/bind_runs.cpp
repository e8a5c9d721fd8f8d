#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/report/report.hpp>
#include <chasles/run_folder/at_times.hpp>
#include <chasles/run_folder/run.hpp>
#include <chasles/session/map_output.hpp>
#include <chasles/session/output_folder.hpp>
#include <chasles/session/report_run.hpp>
#include <chasles/session/run_job.hpp>

#include "arrays.hpp"
#include "interpreter_exit.hpp"
#include "long_call.hpp"
#include "messages.hpp"
#include "module.hpp"
#include "python_run.hpp"

namespace chasles::python {
namespace {

using Eigen::Index;
using Json = nlohmann::ordered_json;

SessionOptions options_of(const py::kwargs& arguments) {
  check_keys("run", arguments,
             {"as_recorded", "begin", "config", "estimator", "keep_images", "map", "mode",
              "progress", "save_map", "threads"});
  SessionOptions o;
  o.quiet = true;
  py::dict settings;
  for (const auto& [key, value] : arguments) {
    const auto name = key.cast<std::string>();
    const std::string found = name + ": found";
    const auto text = [&, &of = value] { return as<std::string>(of, found, "a str"); };
    const auto number = [&, &of = value] { return as<int>(of, found, "an int"); };
    const auto path = [&, &of = value] { return as<std::filesystem::path>(of, found, "a path"); };
    if (name == "estimator") {
      o.estimator = text();
    } else if (name == "threads") {
      o.threads = number();
    } else if (name == "as_recorded") {
      o.as_recorded = as<bool>(value, found, "a bool");
    } else if (name == "begin") {
      o.begin = text();
    } else if (name == "map") {
      o.map = path();
    } else if (name == "save_map") {
      o.save_map = path();
    } else if (name == "keep_images") {
      o.keep_images = number();
    } else if (name == "config") {
      o.settings.config = path().string();
    } else if (name == "mode") {
      o.settings.mode = text();
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

std::vector<std::int64_t> frame_times_of(const Recording& recording) {
  std::vector<std::int64_t> times;
  for (std::size_t i = 0; i < frame_count(recording); ++i) {
    times.push_back(frame_time(recording, i).count());
  }
  return times;
}

// Why the map that is wanted was not saved. The run is not lost with it.
std::optional<Error> unsaved(const SessionOptions& o, const Recording& recording,
                             const CompletedRun& run) {
  try {
    const MapOutcome map = save_map(o, recording, run);
    if (map.not_saved.empty()) return std::nullopt;
    return Error(ExitCode::kNotInitialised, map.not_saved);
  } catch (const Error& error) {
    return error;
  }
}

// Shows the frames of a run that are done.
class ShownProgress : public RunObserver {
 public:
  ShownProgress(LongCall& call, std::size_t frames) : call_(call), frames_(frames) {}
  void on_progress(std::size_t frames, Time /*now*/) override { call_.show(frames, frames_); }

 private:
  LongCall& call_;
  std::size_t frames_;
};

// `path`: where the recording was read, or nothing. With settings of the reader it is read again.
PythonRun run(const Recording& given, const std::filesystem::path& path, const py::object& progress,
              const py::kwargs& arguments) {
  SessionOptions o = options_of(arguments);
  o.input.recording = path;
  LongCall call(progress);
  return call.in_turn([&] {
    PythonRun result;
    Recording recording = given;
    const PlannedRun planned = plan_run(o, recording);
    check_map_output(map_target(o));
    PreparedRun prepared = planned([&] { return call.stopped(); });
    ShownProgress shown(call, frame_count(recording));
    CompletedRun done = prepared.run(shown);
    if (!done.result.report.interrupted) {
      result = {.run = std::move(done.result.run),
                .summary = json_text(done.summary),
                .batch = std::move(done.result.report.estimator.batch_terms),
                .unsaved = unsaved(o, recording, done),
                .frame_times = frame_times_of(recording)};
    }
    return result;
  });
}

// Throws the reason why the run's map was not saved.
void check_map(const PythonRun& r) {
  if (r.unsaved) throw Error(*r.unsaved);
}

PythonRun read_run_folder(const std::filesystem::path& folder) {
  const Released released;
  ReportRun read = read_with_timing(folder);
  return {.run = std::move(read.run), .summary = std::move(read.summary)};
}

Rows covariance_columns(const std::vector<Matrix6d>& covariances) {
  Rows rows(static_cast<Index>(covariances.size()), 36);
  for (std::size_t i = 0; i < covariances.size(); ++i) {
    rows.row(static_cast<Index>(i)) = covariances[i].reshaped<Eigen::RowMajor>().transpose();
  }
  return rows;
}

// The columns of states, whose other states have these names.
py::dict states(const std::vector<RunState>& list, const std::vector<std::string>& names) {
  const auto n = static_cast<Index>(list.size());
  const auto extras = static_cast<Index>(names.size());
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
    const std::string& name = names[static_cast<std::size_t>(k)];
    result[py::str(name)] = Eigen::VectorXd(extra.col(k));
    result[py::str("sigma_" + name)] = Eigen::VectorXd(sigma.col(k));
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

template <typename Row>
py::array known_of(const std::vector<RowAt<Row>>& at, std::vector<Row>& rows) {
  py::array_t<bool> known(static_cast<py::ssize_t>(at.size()));
  for (std::size_t i = 0; i < at.size(); ++i) {
    rows.push_back(at[i].row);
    known.mutable_at(static_cast<py::ssize_t>(i)) = at[i].known;
  }
  return known;
}

// Of the smoothed path: its poses.
py::dict states_at(const PythonRun& r, const py::array& times, bool smoothed, double longest_gap) {
  const std::vector<Time> asked = times_of(times);
  const Time gap = from_seconds(longest_gap);
  py::dict result;
  if (smoothed) {
    std::vector<SmoothedPose> rows;
    const py::array known = known_of(chasles::smoothed_at(r.run, asked, gap), rows);
    result = poses(rows);
    result["known"] = known;
  } else {
    std::vector<RunState> rows;
    const py::array known = known_of(chasles::states_at(r.run, asked, gap), rows);
    result = states(rows, r.run.extra_names);
    result["known"] = known;
  }
  return result;
}

void save(const PythonRun& r, const std::filesystem::path& folder) {
  const Released released;
  prepare_output(folder);
  write_run(r.run, Json::parse(r.summary), folder);
}

std::string page(const PythonRun& r) {
  const Released released;
  return run_page({{.run = r.run, .summary = r.summary}});
}

std::string page_of_all(const std::vector<std::pair<std::string, const PythonRun*>>& named) {
  const Released released;
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
      .def_property_readonly("_frame_times",
                             [](const PythonRun& r) {
                               return Times(Eigen::Map<const Times>(
                                   r.frame_times.data(), static_cast<Index>(r.frame_times.size())));
                             })
      .def_property_readonly("_level", [](const PythonRun& r) { return is_level(r.run); })
      .def_property_readonly(
          "states", [](const PythonRun& r) { return states(r.run.states, r.run.extra_names); })
      .def("_states_at", &states_at)
      .def_property_readonly("smoothed", [](const PythonRun& r) { return poses(r.run.smoothed); })
      .def_property_readonly("in_map", [](const PythonRun& r) { return poses(r.run.in_map); })
      .def_property_readonly("landmarks",
                             [](const PythonRun& r) { return columns(r.run.landmarks); })
      .def_property_readonly("truth", [](const PythonRun& r) { return columns(r.run.truth); })
      .def("_check_map", &check_map)
      .def_property_readonly("_batch", [](const PythonRun& r) { return problems_of(r.batch); })
      .def("save", &save, py::arg("folder"))
      .def("page", &page);
  m.def("run", &run, py::arg("recording"), py::arg("path"), py::arg("progress"), py::pos_only());
  m.def("page", &page_of_all, py::arg("runs"));
  m.def("read_run", &read_run_folder, py::arg("folder"));
}

}  // namespace chasles::python
