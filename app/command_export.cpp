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
#include <chasles/session/settings_io.hpp>
#include <chasles/viewers/square.hpp>

#include "export_formats.hpp"
#include "export_times.hpp"
#include "options.hpp"
#include "print.hpp"
#include "subcommands.hpp"

namespace chasles::app {
namespace {

struct ExportOptions {
  std::filesystem::path folder;
  std::vector<std::filesystem::path> outputs;
  std::string format;  ///< of --as; empty: by the endings
  std::filesystem::path truth;
  ExportChoice choice;
  std::vector<std::string> sets;  ///< of --set
  ExportTimes times;
  bool smoothed = false, quiet = false;
};

std::string truth_of(const ReportRun& run, const ExportOptions& o) {
  if (!nlohmann::ordered_json::parse(run.summary).value("truth_attitudes", true)) {
    throw InputError(
        fmt::format("--truth: that of {} has positions alone, expected a run with a truth "
                    "that has attitudes",
                    o.folder.string()));
  }
  return square_truth(run.run, o.choice.path);
}

void print_size(const std::filesystem::path& file, const std::string& bytes, bool quiet) {
  if (!quiet)
    app::print("{}: {:.1f} MB\n", file.string(), 1e-6 * static_cast<double>(bytes.size()));
}

void write(const std::filesystem::path& file, const std::string& bytes, bool quiet) {
  if (file.has_parent_path()) make_folder(file.parent_path());
  replace_file(file, bytes);
  print_size(file, bytes, quiet);
}

// Replaces earlier files of these names as a whole. Others in the folder stay.
void write(const std::filesystem::path& folder, const Exported& exported, bool quiet) {
  make_folder(folder);
  FileSet set(folder, exported.files.front().name);
  for (const ExportedFile& file : exported.files) set.add(file.name, file.bytes);
  if (exported.images) {
    exported.images->write([&](const std::string& name, const std::string& bytes) {
      make_folder((folder / name).parent_path());
      set.add(name, bytes);
    });
  }
  set.commit();
  for (const ExportedFile& file : exported.files) {
    print_size(folder / file.name, file.bytes, quiet);
  }
}

void print_remarks(const std::vector<std::string>& remarks, bool quiet) {
  if (quiet) return;
  for (const std::string& remark : remarks) app::print("- {}\n", remark);
}

// Leaves the states at the times that are asked for; returns sentences on them.
std::vector<std::string> take_times(const ExportOptions& o, ReportRun& run) {
  if (!o.times.is_asked()) return {};
  for (const std::filesystem::path& output : o.outputs) {
    const ExportFormat& format = export_format(o.format, output);
    if (format.has_path) continue;
    throw UsageError(
        fmt::format("--times and --rate are for formats of a path, found {}, expected "
                    "one of {}",
                    format.name, names_of_paths()));
  }
  return {states_at_times(o.times, o.choice, run)};
}

int export_run(ExportOptions o) {
  if (o.smoothed) o.choice.path = RunPath::kSmoothed;
  for (const std::string& assignment : o.sets) set(list_of(o.choice.colmap), assignment);
  if (!o.format.empty() && o.outputs.size() > 1) {
    throw UsageError(
        fmt::format("--as {}: found {} outputs, expected one -o", o.format, o.outputs.size()));
  }
  for (const std::filesystem::path& output : o.outputs) export_format(o.format, output);
  ReportRun run{.run = read_run(o.folder),
                .summary = json_text(read_summary(o.folder)),
                .label = folder_name(o.folder)};
  print_remarks(take_times(o, run), o.quiet);
  if (!o.truth.empty()) write(o.truth, truth_of(run, o), o.quiet);
  for (const std::filesystem::path& output : o.outputs) {
    const ExportFormat& format = export_format(o.format, output);
    o.choice.output = output;
    const Exported exported = format.make(run, o.choice);
    if (format.is_folder) {
      write(output, exported, o.quiet);
    } else {
      write(output, exported.files.front().bytes, o.quiet);
    }
    print_remarks(exported.remarks, o.quiet);
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
      .add_option(
          "-o,--output", o->outputs,
          "File whose extension chooses the format; may be repeated. " + export_endings_help())
      ->required()
      ->allow_extra_args(false)
      ->type_name("FILE");
  parser
      .add_option(
          "--as", o->format,
          "Format of -o, whatever its name. Those without an extension are " + export_names_help())
      ->type_name(export_names());
  parser.add_flag("--points", o->choice.points,
                  "In .ply no lines between the positions of a trajectory: for readers of point "
                  "clouds that reject edges, such as meshio");
  parser
      .add_option("--recording", o->choice.recording,
                  "The recording of the run, for formats with a row or an image of each frame")
      ->check(require_path)
      ->type_name("RECORDING");
  parser
      .add_option("--body", o->choice.body,
                  "For mavlink: the vehicle's forward, right and down as axes of the IMU (default "
                  "x,-y,-z: forward, left and up)")
      ->type_name("AXES");
  parser.add_flag("--undistort", o->choice.undistort,
                  "With colmap and nerfstudio: write images without the distortion of their lenses "
                  "into OUT/images, for a pinhole camera");
  parser.add_option("--set", o->sets, "A setting of colmap: key=value; may be repeated")
      ->allow_extra_args(false)
      ->type_name("KEY=VALUE");
  parser
      .add_option("--times", o->times.file,
                  "The states at the times in this file, first column, interpolated")
      ->check(require_path)
      ->type_name("FILE");
  parser
      .add_option(
          "--rate", o->times.rate,
          "The states at this rate [Hz], interpolated; or imu: at each sample of the IMU in "
          "--recording, predicted by it from the state before")
      ->type_name("imu|N");
  parser.add_flag("--smoothed", o->smoothed,
                  "The smoothed path, in formats of one path and in --truth");
  parser
      .add_option("--truth", o->truth,
                  "Also write the truth at the times of the poses, in the world of the run (TUM): "
                  "what the poses of a .square are scored by, without an alignment")
      ->type_name("FILE");
  parser.add_flag("--quiet", o->quiet, "Print nothing but errors");
  ColmapSettings colmap;
  parser.footer("Settings for --set with --as colmap or colmap-text:\n" +
                help_text(list_of(colmap)));
  return [o] { return export_run(*o); };
}

}  // namespace chasles::app
