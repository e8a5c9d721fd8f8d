#include <algorithm>
#include <cmath>
#include <new>
#include <optional>

#include <chasles/base/error.hpp>
#include <chasles/base/processor_time.hpp>
#include <chasles/base/stopwatch.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/many/assessed_run.hpp>
#include <chasles/run_folder/run.hpp>
#include <chasles/session/diagnosis.hpp>
#include <chasles/session/fault.hpp>
#include <chasles/session/inertial_settings_io.hpp>
#include <chasles/session/map_output.hpp>
#include <chasles/session/recording_input.hpp>
#include <chasles/session/run_job.hpp>
#include <chasles/session/summary.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kPictures = 3;          // kept for the page of the batch
constexpr std::size_t kSketch = 100;  // positions of the path for it

double minutes_of(const Recording& recording) {
  const std::size_t frames = frame_count(recording);
  if (frames == 0) return 0;
  return to_seconds(frame_time(recording, frames - 1) - frame_time(recording, 0)) / 60;
}

CheckReport checked(const AssessedRunOptions& options, const Recording& recording) {
  if (!options.check) return {};
  // The run is the trial, and what is wrong with a truth says nothing about the poses.
  CheckReport report = examine(recording, kCheckedSeconds,
                               inertial_run_settings_from(options.session.settings).frontend);
  std::erase_if(report.findings, [](const Finding& finding) { return finding.about == "truth"; });
  return report;
}

// Positions from above [m], at most kSketch of them, relative to the first.
template <typename Poses>
Json sketch_of(const Poses& poses) {
  Json x = Json::array(), y = Json::array();
  const std::size_t step = std::max<std::size_t>(1, (poses.size() + kSketch - 1) / kSketch);
  const auto rounded = [](double metres) { return std::round(1000 * metres) / 1000; };
  for (std::size_t i = 0; i < poses.size(); i += step) {
    const Eigen::Vector3d p = poses[i].world_T_imu.p - poses[0].world_T_imu.p;
    x.push_back(rounded(p.x()));
    y.push_back(rounded(p.y()));
  }
  return {{"x", std::move(x)}, {"y", std::move(y)}};
}

Json sketch(const Run& run, const std::optional<PathFigures>& path) {
  if (!path) return nullptr;
  if (path->path == "in_map") return sketch_of(run.in_map);
  return path->path == "smoothed" ? sketch_of(run.smoothed) : sketch_of(run.states);
}

// A recording that was copied here from its source is named by that.
std::string with_source(std::string what, const BatchItem& item) {
  if (item.source.empty()) return what;
  const std::string path = item.recording.string();
  for (std::size_t at = 0; (at = what.find(path, at)) != std::string::npos;) {
    what.replace(at, path.size(), item.source);
    at += item.source.size();
  }
  return what;
}

Json reasons_json(const BatchItem& item, const std::vector<Reason>& reasons) {
  Json list = Json::array();
  for (const Reason& reason : reasons) {
    list.push_back({{"reason", reason.kind}, {"what", with_source(reason.what, item)}});
  }
  return list;
}

Json record_head(const BatchItem& item, const std::vector<Reason>& reasons) {
  return {{"name", item.name},
          {"recording", item.said_source()},
          {"options", item.options_json()},
          {"verdict", name_of(verdict_of(reasons))},
          {"reasons", reasons_json(item, reasons)}};
}

Json finite(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

void add_figures(Json& record, const Json& summary, const std::optional<PathFigures>& path) {
  const auto take = [&](const char* name) {
    const auto found = summary.find(name);
    record[name] = found == summary.end() ? Json(nullptr) : *found;
  };
  take("health");
  record["coverage"] = path ? path->coverage : 0;
  for (const char* name : {"frames", "recorded_seconds", "start_seconds"}) take(name);
  record["path"] = path ? Json(path->path) : Json(nullptr);
  if (!path) return;
  record["length_m"] = path->length_m;
  record["worst_sigma_m"] = finite(path->worst_sigma_m);
  record["bound_m"] = finite(kBoundSigmas * path->worst_sigma_m);
  record["worst_sigma_deg"] = finite(path->worst_turn_deg);
  record["drift_m_per_100m"] = finite(path->drift_m_per_100m);
  // The truth is not in the frame of a map; without one `matched` is null.
  const auto matched = summary.find("matched");
  const bool has_truth =
      matched != summary.end() && matched->is_number() && matched->get<double>() > 0;
  if (path->path == "in_map" || !has_truth) return;
  const Json& errors =
      path->path == "smoothed" && summary.contains("smoothed") ? summary.at("smoothed") : summary;
  for (const char* name : {"ate_m", "ate_posyaw_m", "nees_pose"}) record[name] = errors.at(name);
}

CompletedRun completed(const SessionOptions& session, Recording& recording) {
  RunObserver nobody;
  return plan_run(session, recording)([] { return false; }).run(nobody);
}

struct EstimatedRun {
  CompletedRun run;
  std::vector<Reason> reasons;  // against how it was estimated
};

// Batch estimation needs parallax, and a camera that hardly moves has none: then the filter.
EstimatedRun estimated(SessionOptions& session, Recording& recording) {
  try {
    return {completed(session, recording), {}};
  } catch (const InputError& error) {
    if (!session.settings.estimator.is_batch()) throw;
    session.settings.estimator = {.kind = EstimatorChoice::Kind::kFilter};
    recording = read_input(session.input);
    return {completed(session, recording), {{"filter_only", error.what()}}};
  }
}

// Writes the run folder, and the map where that is wanted.
void deliver(const SessionOptions& session, const Recording& recording, const CompletedRun& run,
             const std::filesystem::path& folder, const Stopwatch& wall) {
  write_run(run.result.run, run.summary, folder, [&] {
    const double recorded = 60 * minutes_of(recording);
    return json_text(timing_json(run.result, recorded, wall.seconds(), process_seconds()), 2) +
           "\n";
  });
  const MapOutcome map = save_map(session, recording, run);
  if (!map.not_saved.empty()) throw Error(ExitCode::kNotInitialised, map.not_saved);
}

Json run_and_assess(const AssessedRunOptions& options, const BatchItem& item,
                    const std::filesystem::path& folder, const std::function<void(double)>& known) {
  SessionOptions session = session_of(options.session, item);
  Recording recording = read_input(session.input);
  known(minutes_of(recording));
  const CheckReport check = checked(options, recording);
  if (recording.images && recording.velocities.empty()) {
    session.keep_images =
        std::max(1, (static_cast<int>(frame_count(recording)) + kPictures - 1) / kPictures);
  }
  const Stopwatch wall;
  std::optional<EstimatedRun> done;
  try {
    done = estimated(session, recording);
  } catch (const InputError& error) {
    return record_without_run(item, {"not_estimated", error.what()});
  }
  CompletedRun& run = done->run;
  try {
    deliver(session, recording, run, folder, wall);
  } catch (const UsageError& error) {
    return {{kOutputError, error.what()}};
  }
  const bool in_map = !session.map.empty();
  const RecordedRun& result = run.result;
  const std::optional<PathFigures> path = path_figures(result.run, result.coverage, in_map);
  Json record = record_head(item, reasons_against(run.summary, path, in_map, check, options.limits,
                                                  std::move(done->reasons)));
  add_figures(record, run.summary, path);
  record["sketch"] = sketch(result.run, path);
  return record;
}

}  // namespace

SessionOptions session_of(const SessionOptions& all, const BatchItem& item) {
  SessionOptions session = all;
  session.quiet = true;
  session.input.recording = item.recording;
  if (!item.truth.empty()) session.input.truth = item.truth;
  if (!item.cameras.empty()) session.input.cameras = item.cameras;
  if (item.start) session.input.start = item.start;
  if (item.stop) session.input.stop = item.stop;
  session.settings.sets.insert(session.settings.sets.end(), item.sets.begin(), item.sets.end());
  return session;
}

Json record_without_run(const BatchItem& item, const Reason& reason) {
  return record_head(item, {reason});
}

Json assessed_run(const AssessedRunOptions& options, const BatchItem& item,
                  const std::filesystem::path& folder, const std::function<void(double)>& known) {
  try {
    return run_and_assess(options, item, folder, known);
  } catch (const Error& error) {
    return record_without_run(item, reason_of(error));
  } catch (const std::bad_alloc&) {
    return record_without_run(item, {"memory", "not enough memory"});
  } catch (const std::exception& error) {
    return record_without_run(item, {"died", fault_of(error).sentence});
  }
}

}  // namespace chasles
