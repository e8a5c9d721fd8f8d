#include "run_command_options.hpp"

#include <charconv>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/session/image_keeper.hpp>

#include "declare_truth.hpp"
#include "method_options.hpp"
#include "options.hpp"

namespace chasles::app {
namespace {

void declare_threads(CLI::App& parser, int& threads) {
  parser
      .add_option("--threads", threads,
                  "3 (default): one thread reads images and one tracks features, both ahead of the "
                  "filter; 2: only the tracking thread; 1: neither. The results are the same bytes")
      ->type_name("N")
      ->check(CLI::Range(1, 3))
      ->group("Method");
}

void declare_input(CLI::App& parser, RunCommandOptions& o) {
  parser
      .add_option("RECORDING", o.input.recording,
                  "EuRoC, KITTI or image folder, video, bag of ROS 1 or ROS 2, ECE276A .npz, STARS "
                  ".mat, AprilGrid tracks, or the project's own folder (docs/formats.md)")
      ->required()
      ->type_name("");
  const auto add = [&](const char* name, std::filesystem::path& path, const char* meaning) {
    parser.add_option(name, path, meaning)->type_name("FILE")->group("Input");
  };
  add("--truth", o.input.truth,
      "True trajectory: TUM, a bag with its poses (FILE or FILE:TOPIC), or a recording that has it "
      "(default: the recording's own)");
  declare_truth(parser, o.input.truth_options, "Input");
  declare_truth_errors(parser, o.input.truth_options, "Input");
  add("--trajectory", o.trajectory, "Trajectory (TUM) to map along, with --mode map");
  parser
      .add_option(
          "--cameras", o.input.cameras,
          "mono or stereo: the first camera, or the first two; or the numbers of cameras in "
          "the order of their use, as 0,2,3. The files of later ones are ignored (default: "
          "all cameras)")
      ->type_name("mono|stereo")
      ->group("Input");
  parser.add_flag("--backwards", o.input.backwards, "Play the recording from its end")
      ->group("Input");
  add_number(parser, "--start", o.input.start, "S", "Leave out the recording before this second", 0)
      ->group("Input");
  add_number(parser, "--stop", o.input.stop, "S", "Leave out the recording after this second", 0)
      ->group("Input");
  add_number(parser, "--tracks", o.input.tracks.part, "PART",
             "Use a random part of the tracks, from 0 to 1, to test how much the result depends on "
             "the choice of points (default: all)",
             0, 1)
      ->group("Input");
  const auto read_seed = [&seed = o.input.tracks.seed](const std::string& text) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
    if (error == std::errc() && end == text.data() + text.size()) return;
    throw UsageError("--tracks-seed: found " + text + ", expected a whole number from 0 on");
  };
  parser
      .add_option_function<std::string>("--tracks-seed", read_seed,
                                        "Seed of that random part (default: 1)")
      ->type_name("N")
      ->group("Input");
  parser
      .add_flag("--tracks-rest", o.input.tracks.rest,
                "Use the tracks that --tracks leaves out, for `chasles evaluate --pair`")
      ->needs("--tracks")
      ->group("Input");
}

void declare_map(CLI::App& parser, RunCommandOptions& o) {
  const auto add = [&](const char* name, std::filesystem::path& path, const char* meaning) {
    return parser.add_option(name, path, meaning)
        ->type_name("MAP")
        ->group("Map")
        ->check(require_path);
  };
  CLI::Option* map =
      add("--map", o.map,
          "Find the place in a map that an earlier run saved, by its appearance, and estimate with "
          "it (implies recognise=appearance; docs/recognition.md)");
  parser.add_flag("--extend", o.extend, "Save the map with what this run adds to it")
      ->group("Map")
      ->needs(map);
  add("--save-map", o.save_map,
      "Save landmarks, their appearance and their joint covariance for later runs (implies "
      "recognise=appearance)");
}

void declare_realtime(CLI::App& parser, RunCommandOptions& o) {
  parser
      .add_flag(
          "--realtime", o.realtime,
          "Play the recording in real time (visual-inertial runs). Frames that the run cannot "
          "process in time are dropped and counted, so results depend on the machine")
      ->group("Method");
  add_number(parser, "--realtime-speed", o.realtime_speed, "X",
             "As --realtime, at X times the real speed", 0.001, 1e6)
      ->group("Method");
}

int every_of(const std::string& text) {
  int every = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, every);
  if (text.empty() || (error == std::errc() && stop == end && every > 0)) return every;
  throw UsageError(
      fmt::format("--keep-images: found '{}', expected a number of frames, 1 or more", text));
}

void declare_keep_images(CLI::App& parser, std::optional<int>& every) {
  parser
      .add_option_function<std::string>(
          "--keep-images", [&every](const std::string& text) { every = every_of(text); },
          fmt::format(
              "Keep every N-th frame for viewing (default: about {} frames): per camera a JPEG of "
              "at most {} px width, about 20 kB, and the tracked points with their outcomes. The "
              "page shows as many as fit into 8 MB",
              ImageKeeper::kFrames, ImageKeeper::kWidth))
      ->expected(0, 1)
      ->type_name("[N]")
      ->group("Output");
}

void declare_output(CLI::App& parser, RunCommandOptions& o) {
  parser
      .add_option("-o,--output", o.output,
                  "Folder for the run (default: only the summary is printed)")
      ->check(require_path)
      ->type_name("RUN")
      ->group("Output");
  parser
      .add_option("--full-covariance", o.full_covariance,
                  "Joint covariance of state and whole map as .npy (may take gigabytes)")
      ->type_name("FILE")
      ->group("Output");
  declare_keep_images(parser, o.keep_images);
  declare_live(parser, o.live);
  parser.add_flag("--json", o.json, "Print the summary as JSON")->group("Output");
  parser.add_flag("--quiet", o.quiet, "No progress and no log, only errors")->group("Output");
}

}  // namespace

void declare_run_options(CLI::App& parser, RunCommandOptions& options) {
  declare_input(parser, options);
  declare_method(parser, options);
  declare_threads(parser, options.threads);
  declare_map(parser, options);
  declare_realtime(parser, options);
  declare_output(parser, options);
  add_options(parser, options.thresholds);
  parser.footer(method_help());
}

}  // namespace chasles::app
