#include "calibrate_views.hpp"

#include <algorithm>
#include <mutex>
#include <thread>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/cameras_report.hpp>
#include <chasles/calibrate/cross_validation.hpp>
#include <chasles/calibrate/recorded_views.hpp>
#include <chasles/session/progress.hpp>
#include <chasles/target/target_file.hpp>

namespace chasles::app {

void declare_views(CLI::App& parser, ViewsOptions& o, bool has_imu) {
  o.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  parser
      .add_option("RECORDING", o.recordings,
                  has_imu ? "Recordings of a moving rig with an IMU; without --target, one"
                          : "Recordings of the target, or folders of images, by the same cameras")
      ->required()
      ->type_name("");
  CLI::Option* target =
      parser
          .add_option("--target", o.target,
                      has_imu ? "File of the target (docs/calibration.md), which may be moved "
                                "between recordings; without it: from any motion, by batch "
                                "estimation"
                              : "File of the target (docs/calibration.md)")
          ->type_name("FILE");
  if (!has_imu) target->required();
  parser
      .add_option("--lens", o.lens,
                  "Lens model, or several of which views that took no part choose the best, as "
                  "radtan,radtan:8,ds (default auto: the common ones)")
      ->type_name("MODELS");
  parser.add_option("--every", o.every, "Search one of so many frames (default 1)")
      ->check(CLI::Range(1, 1000000))
      ->type_name("N");
  parser.add_option("--threads", o.threads, "Images searched in parallel (default: one per core)")
      ->check(CLI::Range(1, 256))
      ->type_name("N");
  parser.add_flag("--from-nothing", o.from_nothing,
                  has_imu ? "Do not begin at the lens, or without a target at the mounting, that "
                            "the recording states"
                          : "Do not begin at the lens that the recording states");
  parser.add_flag(
      "--live", o.live,
      "Follow a folder to which another program writes images, and say what is missing, "
      "until Ctrl-C; then calibrate with all of them");
  parser.add_flag("--quiet", o.quiet, "Print nothing but errors");
}

void check_symmetry(const ViewsOptions& o, const Target& target, std::size_t cameras) {
  if (!target.is_symmetric() || (cameras < 2 && !o.follows_target)) return;
  throw InputError(fmt::format(
      "--target {}: the board looks the same after half a turn, so its views may be mixed up: "
      "expected columns + rows to be odd, or a board with tags",
      o.target.string()));
}

void gather_views(const ViewsOptions& o, const Recording& recording, const Interrupt& interrupt,
                  CamerasInput& input, std::vector<std::string>& remarks) {
  const Target target = read_target(o.target);
  check_symmetry(o, target, recording.cameras.size());
  if (!input.cameras.empty() && recording.cameras.size() != input.cameras.size()) {
    throw InputError(fmt::format("{}: found {} cameras, expected {} as in {}", recording.name,
                                 recording.cameras.size(), input.cameras.size(),
                                 o.recordings.front().string()));
  }
  for (std::size_t c = 0; c < input.cameras.size(); ++c) {
    const Camera &first = input.cameras[c], &here = recording.cameras[c];
    if (first.width == here.width && first.height == here.height) continue;
    throw InputError(fmt::format("{}: cam{} has images of {} x {}, expected {} x {} as in {}",
                                 recording.name, c, here.width, here.height, first.width,
                                 first.height, o.recordings.front().string()));
  }
  if (input.cameras.empty()) input.cameras = recording.cameras;
  ViewOptions options{.every = o.every, .threads = o.threads, .progress = {}, .known = o.known};
  Progress bar(searched_frames(recording, options), o.quiet);
  std::mutex drawing;
  options.progress = [&](std::size_t done) {
    const std::lock_guard lock(drawing);
    bar.show(done);
    return !interrupt.requested();
  };
  RecordedViews views = recorded_views(recording, target, options);
  if (interrupt.requested()) {
    remarks.push_back(fmt::format("interrupted: {} views of {} were found until then",
                                  views.views.size(), recording.name));
  }
  for (const std::string& sentence : views.damaged) remarks.push_back(sentence);
  for (std::string& sentence : blurred_views(views)) remarks.push_back(std::move(sentence));
  for (std::size_t c = 0; c < views.seen.size(); ++c) {
    remarks.push_back(fmt::format("{}, cam{}: the target is in {} of {} images", recording.name, c,
                                  views.seen[c], views.frames));
  }
  if (std::ranges::all_of(views.seen, [](std::size_t images) { return images == 0; })) {
    throw InputError(fmt::format("{}: the target is in none of {} images{}{}", recording.name,
                                 views.frames,
                                 views.lacks.empty() ? "" : "; the first that has a part of it: ",
                                 views.lacks.empty() ? std::string() : views.lacks.front()));
  }
  // Instants of two recordings are not the same.
  Time shift{};
  if (!input.views.empty() && !views.views.empty()) {
    shift = input.views.back().time + std::chrono::seconds(10) - views.views.front().time;
  }
  for (TargetView& view : views.views) {
    view.time += shift;
    input.views.push_back(std::move(view));
  }
}

std::vector<LensForm> candidate_lenses(const ViewsOptions& o) {
  return lens_candidates(o.lens, "--lens");
}

void check_different(const std::vector<std::filesystem::path>& recordings) {
  for (auto path = recordings.begin(); path != recordings.end(); ++path) {
    if (std::find(recordings.begin(), path, *path) == path) continue;
    throw UsageError(
        fmt::format("{}: is there twice, expected each recording once: its views would count as "
                    "independent ones",
                    path->string()));
  }
}

void check_is_new(const std::filesystem::path& folder) {
  std::error_code ignored;
  if (folder.empty() || !std::filesystem::exists(folder, ignored)) return;
  if (std::filesystem::is_directory(folder, ignored) &&
      std::filesystem::is_empty(folder, ignored)) {
    return;
  }
  throw UsageError(fmt::format(
      "-o {}: is there and not empty, expected a new folder: remove it, or name another",
      folder.string()));
}

std::vector<CalibrationView> page_views(const std::vector<ExplainedView>& views) {
  const double limit = suspicious_rms(views);
  std::vector<CalibrationView> result;
  for (const ExplainedView& view : views) {
    result.push_back({.seconds = to_seconds(view.view.time),
                      .camera = view.view.camera,
                      .is_suspicious = view.rms > limit,
                      .rms = view.rms,
                      .pixels = view.view.pixels,
                      .errors = view.errors});
  }
  return result;
}

CamerasInput input_for(const Target& target) {
  return {.corners = target.corners(),
          .views = {},
          .cameras = {},
          .lenses = {},
          .shape = printed_shape(target)};
}

}  // namespace chasles::app
