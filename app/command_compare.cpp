#include <filesystem>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/eval/evaluation.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/report/study.hpp>

#include "compare_material.hpp"
#include "filter_options.hpp"
#include "interrupt.hpp"
#include "lab_report.hpp"
#include "lab_scene.hpp"
#include "loops_options.hpp"
#include "options.hpp"
#include "output_folder.hpp"
#include "print.hpp"
#include "progress.hpp"
#include "run_figures.hpp"
#include "scene_options.hpp"
#include "subcommands.hpp"
#include "summary.hpp"

namespace chasles::app {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

struct CompareOptions {
  SceneChoice scene;
  FilterOptions filters;
  fs::path output;
  std::uint64_t run = 0;
  bool json = false, markdown = false, quiet = false;
};

/// A trial of a filter with its figures.
struct Compared {
  Trial trial;
  FilterSummary summary;  ///< of this one run
  Json figures;
};

// The figures against the truth, with the NEES of the trial. No alignment is needed, because the
// trial uses the world of the truth.
void add_evaluation(const Trial& trial, const Trajectory& truth, Json& figures) {
  Json all;
  try {
    all = figures_json(evaluate(trial.estimate, truth));
  } catch (const InputError& error) {
    all = figures_json(Evaluation{});
  }
  for (const auto& [name, value] : all.items()) {
    if (!figures.contains(name)) figures[name] = value;
  }
}

Compared compare_one(const FilterVariant& filter, const CompareMaterial& material) {
  Compared result{.trial = material.run(filter), .summary = {}, .figures = {}};
  const TrialRecord record = record_of(result.trial);
  result.summary = summarize({&filter, 1}, {&record, 1}).front();
  result.figures = figures_json(filter, result.summary);
  result.figures["frames"] = result.trial.points.size();
  result.figures["recorded_seconds"] =
      result.trial.points.empty() ? 0 : result.trial.points.back().seconds;
  result.figures["health"] = result.trial.diverged ? "lost" : "ok";
  add_evaluation(result.trial, material.truth, result.figures);
  result.figures["settings"] = material.settings(filter);
  return result;
}

std::string points_csv(const Trial& trial) {
  // Two-sided 95 % bounds of one chi-square variable.
  const Band three = chi2_band(3, 1), six = chi2_band(6, 1);
  std::string text =
      "seconds,position_error_m,attitude_error_deg,nees_position,nees_attitude,nees_pose,nees_"
      "state,nis,"
      "nis_dof,band_3_low,band_3_high,band_6_low,band_6_high\n";
  for (const TrialPoint& p : trial.points) {
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{}\n", p.seconds, p.position_error,
                        p.attitude_error * kDegrees, p.nees_position, p.nees_attitude, p.nees_pose,
                        p.nees_state, p.nis, p.nis_dof, three.low, three.high, six.low, six.high);
  }
  return text;
}

double milliseconds(const Trial& trial) {
  return 1e3 * trial.seconds_cpu /
         static_cast<double>(std::max<std::size_t>(trial.points.size(), 1));
}

Json timing_of(const std::vector<Compared>& all) {
  Json timing = Json::object();
  for (const Compared& one : all) {
    timing[one.trial.filter] = {{"seconds_cpu", one.trial.seconds_cpu},
                                {"milliseconds_per_frame", milliseconds(one.trial)}};
  }
  return timing;
}

Json summary_of(const CompareOptions& o, const CompareMaterial& material,
                const std::vector<Compared>& all) {
  Json summary{{"name", material.name},      {"version", CHASLES_VERSION},
               {"seed", material.seed},      {"run", o.run},
               {"filters", Json::array()},   {"scene", material.scene},
               {"remarks", material.remarks}};
  for (const Compared& one : all) summary["filters"].push_back(one.figures);
  return summary;
}

// True ones or a map, for the top view of the report, in the format of a recording.
template <typename Landmarks>
void add_landmarks(const Landmarks& landmarks, const std::string& name, FileSet& files) {
  if (landmarks.empty()) return files.remove(name);
  std::string rows = "landmark,x,y,z\n";
  for (const auto& row : landmarks) {
    if (!row.p_world.allFinite()) continue;
    rows += fmt::format("{},{},{},{}\n", row.id, row.p_world.x(), row.p_world.y(), row.p_world.z());
  }
  files.add(name, rows);
}

void write(const CompareOptions& o, const CompareMaterial& material,
           const std::vector<Compared>& all, const Json& summary) {
  FileSet files(o.output, "summary.json");
  for (const Compared& one : all) {
    files.add(one.trial.filter + ".csv", points_csv(one.trial));
    write_tum(one.trial.estimate, files.place(one.trial.filter + ".tum"));
    add_landmarks(one.trial.map, one.trial.filter + kLandmarksFile + ".csv", files);
  }
  write_tum(material.truth, files.place("truth.tum"));
  add_landmarks(material.landmarks, "landmarks_truth.csv", files);
  files.add("timing.json", json_text(timing_of(all), 2) + "\n");
  files.add("summary.json", json_text(summary, 2) + "\n");
  files.commit();
}

void print(const CompareOptions& o, const CompareMaterial& material,
           const std::vector<Compared>& all, Json summary) {
  if (o.json) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      summary["filters"][i]["seconds_cpu"] = all[i].trial.seconds_cpu;
      summary["filters"][i]["milliseconds_per_frame"] = milliseconds(all[i].trial);
    }
    app::print("{}\n", json_text(summary, 2));
    return;
  }
  std::vector<FilterSummary> summaries;
  std::vector<double> cpu;
  for (const Compared& one : all) {
    summaries.push_back(one.summary);
    cpu.push_back(milliseconds(one.trial));
  }
  if (!o.markdown) {
    app::print("{}: {} frames, seed {}, run {}\n\n", material.name, material.frames, material.seed,
               o.run);
  }
  app::print("{}", tables(summaries, cpu, o.markdown ? TableStyle::kMarkdown : TableStyle::kText));
}

int exit_code(const std::vector<Compared>& all) {
  std::size_t diverged = 0;
  for (const Compared& one : all) {
    if (!one.trial.diverged) continue;
    ++diverged;
    spdlog::warn("{} diverged after {} frames", one.trial.filter, one.trial.points.size());
  }
  return static_cast<int>(diverged == all.size() ? ExitCode::kDiverged : ExitCode::kOk);
}

int compare(const CompareOptions& o) {
  if (o.quiet) spdlog::set_level(spdlog::level::err);
  std::optional<EndAtOnce> end(std::in_place, std::vector<fs::path>{});
  const CompareMaterial material = compare_material(o.scene, o.filters, o.run);
  const std::vector<FilterVariant>& filters = material.filters;
  const bool scene = is_inertial_scene(o.scene.name) || is_loops(o.scene.name);
  if (!scene) reject_output_into(o.output, o.scene.name);
  if (!o.output.empty()) {
    const SignalsHeld held;
    end.emplace(prepare_output(o.output));
  }
  std::vector<Compared> all;
  {
    Progress progress(filters.size(), o.quiet, "filters");
    double recorded = 0;
    for (const FilterVariant& filter : filters) {
      all.push_back(compare_one(filter, material));
      recorded += all.back().figures["recorded_seconds"].get<double>();
      progress.show(all.size(), recorded);
    }
  }
  end.reset();
  const Json summary = summary_of(o, material, all);
  if (!o.output.empty()) write(o, material, all, summary);
  print(o, material, all, summary);
  return exit_code(all);
}

}  // namespace

Action declare_compare(CLI::App& parser) {
  const auto o = std::make_shared<CompareOptions>();
  parser
      .add_option("SCENE", o->scene.name,
                  lab_scene_names() + ", or a recording with IMU, cameras and truth")
      ->required()
      ->type_name("");
  declare_scene(parser, o->scene);
  parser.add_option("--run", o->run, "Number of the noise realisation")
      ->type_name("K")
      ->group("Scene");
  declare_filters(parser, o->filters);
  parser.add_option("-o,--output", o->output, "Folder for the errors, trajectories and figures")
      ->check(require_path)
      ->type_name("DIR")
      ->group("Output");
  CLI::Option* json = parser.add_flag("--json", o->json, "Print the figures as JSON");
  json->group("Output");
  parser.add_flag("--markdown", o->markdown, "Print the tables as Markdown")
      ->excludes(json)
      ->group("Output");
  parser.add_flag("--quiet", o->quiet, "No progress and no log, only errors")->group("Output");
  parser.footer(lab_help());
  return [o] { return compare(*o); };
}

}  // namespace chasles::app
