#include <map>
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/folder_names.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/run_folder/run.hpp>
#include <chasles/viewers/kml.hpp>
#include <chasles/viewers/ply.hpp>
#include <chasles/viewers/run_mcap.hpp>
#include <chasles/viewers/square.hpp>

#include "print.hpp"
#include "subcommands.hpp"

namespace chasles::app {
namespace {

struct ExportOptions {
  std::filesystem::path folder;
  std::vector<std::filesystem::path> outputs;
  std::filesystem::path truth;
  bool points = false, smoothed = false;
  bool quiet = false;
};

RunPath path_of(const ExportOptions& o) {
  return o.smoothed ? RunPath::kSmoothed : RunPath::kStates;
}

std::string truth_of(const ReportRun& run, const ExportOptions& o) {
  if (!nlohmann::ordered_json::parse(run.summary).value("truth_attitudes", true)) {
    throw InputError(
        fmt::format("--truth: that of {} has positions alone, expected a run with a truth "
                    "that has attitudes",
                    o.folder.string()));
  }
  return square_truth(run.run, path_of(o));
}

using Writer = std::string (*)(const ReportRun& run, const ExportOptions& o);

// Chooses the writer by the file's extension.
Writer writer_for(const std::filesystem::path& file) {
  static const std::map<std::string, Writer> writers{
      {".mcap",
       [](const ReportRun& r, const ExportOptions&) { return run_mcap(r, CHASLES_VERSION); }},
      {".ply",
       [](const ReportRun& r, const ExportOptions& o) {
         return run_ply(r.run, o.points ? PlyEdges::kNo : PlyEdges::kYes);
       }},
      {".kml", [](const ReportRun& r, const ExportOptions&) { return run_kml(r.run); }},
      {".square", [](const ReportRun& r, const ExportOptions& o) {
         return run_square(r.run, path_of(o), CHASLES_VERSION);
       }}};
  const std::string ending = file.extension().string();
  const auto writer = writers.find(ending);
  if (writer != writers.end()) return writer->second;
  throw UsageError(fmt::format("-o: {} ends with '{}', expected .mcap, .ply, .kml or .square",
                               file.string(), ending));
}

void write(const std::filesystem::path& file, const std::string& bytes, bool quiet) {
  if (file.has_parent_path()) make_folder(file.parent_path());
  replace_file(file, bytes);
  if (!quiet)
    app::print("{}: {:.1f} MB\n", file.string(), 1e-6 * static_cast<double>(bytes.size()));
}

int export_run(const ExportOptions& o) {
  for (const std::filesystem::path& file : o.outputs) writer_for(file);
  const ReportRun run{.run = read_run(o.folder),
                      .summary = json_text(read_summary(o.folder)),
                      .label = folder_name(o.folder)};
  if (!o.truth.empty()) write(o.truth, truth_of(run, o), o.quiet);
  for (const std::filesystem::path& file : o.outputs) {
    write(file, writer_for(file)(run, o), o.quiet);
  }
  return 0;
}

}  // namespace

Action declare_export(CLI::App& parser) {
  const auto o = std::make_shared<ExportOptions>();
  parser.add_option("RUN", o->folder, "Run folder, as `chasles run -o` writes it")
      ->required()
      ->type_name("");
  parser
      .add_option("-o,--output", o->outputs,
                  "File whose extension chooses the format; may be repeated. .mcap: for Foxglove "
                  "and Rerun; .ply: map and trajectories, for CloudCompare, MeshLab, Blender; "
                  ".kml: trajectories on the Earth, for a georeferenced recording; .square: poses "
                  "with covariances, for smfeval")
      ->required()
      ->allow_extra_args(false)
      ->type_name("FILE");
  parser.add_flag("--points", o->points,
                  "In .ply no lines between the positions of a trajectory: for readers of point "
                  "clouds that reject edges, such as meshio");
  parser.add_flag("--smoothed", o->smoothed, "In .square and --truth the smoothed path");
  parser
      .add_option("--truth", o->truth,
                  "Also write the truth at the times of the poses, in the world of the run (TUM): "
                  "what the poses of a .square are scored by, without an alignment")
      ->type_name("FILE");
  parser.add_flag("--quiet", o->quiet, "Print nothing but errors");
  return [o] { return export_run(*o); };
}

}  // namespace chasles::app
