#include <memory>
#include <thread>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/calibrate/cameras_report.hpp>
#include <chasles/calibrate/projection_uncertainty.hpp>
#include <chasles/calibrate/target_pose.hpp>
#include <chasles/calibration/calibration.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/session/interrupt.hpp>
#include <chasles/session/progress.hpp>
#include <chasles/target/target_file.hpp>

#include "calibrate_commands.hpp"
#include "options.hpp"
#include "print.hpp"

namespace chasles::app {
namespace {

namespace fs = std::filesystem;

struct CamerasOptions {
  std::vector<fs::path> recordings;
  fs::path target, out;
  std::string lens = "auto";
  int every = 1, threads = 0;
  bool from_nothing = false, json = false, quiet = false;
};

// The views of all recordings, one after the other in time.
CamerasInput gathered(const CamerasOptions& o, const Target& target, const Interrupt& interrupt,
                      CamerasReport& report) {
  CamerasInput input{.corners = target.corners(),
                     .views = {},
                     .cameras = {},
                     .lenses = {},
                     .shape = printed_shape(target)};
  Time shift{};
  for (const fs::path& path : o.recordings) {
    const Recording recording = read_recording(path);
    if (!input.cameras.empty() && recording.cameras.size() != input.cameras.size()) {
      throw InputError(fmt::format("{}: found {} cameras, expected {} as in {}", path.string(),
                                   recording.cameras.size(), input.cameras.size(),
                                   o.recordings.front().string()));
    }
    if (input.cameras.empty()) input.cameras = recording.cameras;
    ViewOptions options{.every = o.every, .threads = o.threads, .progress = {}};
    Progress bar(searched_frames(recording, options), o.quiet);
    options.progress = [&](std::size_t done) {
      if (options.threads == 1) bar.show(done);
      return !interrupt.requested();
    };
    RecordedViews views = recorded_views(recording, target, options);
    if (interrupt.requested()) {
      report.remarks.push_back(fmt::format("interrupted: {} views are from {} and those before",
                                           views.views.size(), path.string()));
    }
    for (const std::string& sentence : views.damaged) report.remarks.push_back(sentence);
    // Instants of two recordings are not the same.
    const Time first = views.views.empty() ? Time{} : views.views.front().time;
    for (TargetView& view : views.views) {
      if (o.recordings.size() > 1) view.time += shift - first;
      input.views.push_back(std::move(view));
    }
    if (!input.views.empty()) shift = input.views.back().time + std::chrono::seconds(10);
  }
  return input;
}

std::vector<LensForm> candidates_of(const CamerasOptions& o) {
  if (o.lens == "auto") return common_lenses();
  std::vector<LensForm> lenses;
  for (std::size_t begin = 0; begin <= o.lens.size();) {
    const std::size_t end = std::min(o.lens.find(',', begin), o.lens.size());
    lenses.push_back(lens_form(o.lens.substr(begin, end - begin), "--lens"));
    begin = end + 1;
  }
  return lenses;
}

// With the lens that the recording states, each view with the pose that is best.
double rms_with(const Camera& camera, const CamerasInput& input, std::size_t c) {
  if (camera.fx <= 0) return kNaN;
  double squares = 0, corners = 0;
  for (const TargetView& view : input.views) {
    if (view.camera != static_cast<int>(c)) continue;
    const auto pose = target_pose(camera, input.corners, view);
    if (!pose) continue;
    squares += pose->rms * pose->rms * static_cast<double>(view.ids.size());
    corners += static_cast<double>(view.ids.size());
  }
  return corners > 0 ? std::sqrt(squares / corners) : kNaN;
}

void write_result(const CamerasReport& report, const fs::path& folder) {
  fs::create_directories(folder);
  FolderCalibration calibration{.name = "calibration"};
  calibration.cameras = report.calibration.cameras;
  write_calibration(calibration, folder / "calibration.yaml");
  replace_file(folder / "cameras.json", json_text(cameras_json(report), 2) + "\n");
  std::string rows = "time_s,camera,corner,u_px,v_px,error_u_px,error_v_px\n";
  for (const ExplainedView& view : report.calibration.views) {
    for (std::size_t i = 0; i < view.errors.size(); ++i) {
      rows += fmt::format("{:.9f},{},{},{:.4f},{:.4f},{:.4f},{:.4f}\n", to_seconds(view.view.time),
                          view.view.camera, view.view.ids[i], view.view.pixels[i].x(),
                          view.view.pixels[i].y(), view.errors[i].x(), view.errors[i].y());
    }
  }
  replace_file(folder / "corners.csv", rows);
}

int calibrate(const CamerasOptions& o) {
  const Target target = read_target(o.target);
  const Interrupt interrupt;
  CamerasReport report;
  report.input = gathered(o, target, interrupt, report);
  CamerasInput& input = report.input;
  const std::vector<LensForm> candidates = candidates_of(o);
  for (std::size_t c = 0; c < input.cameras.size(); ++c) {
    report.rms_before.push_back(rms_with(input.cameras[c], input, c));
    if (o.from_nothing) input.cameras[c].fx = 0;
    std::optional<LensChoice> choice;
    if (candidates.size() > 1) choice = choose_lens(input, c, candidates);
    input.lenses.push_back(choice ? choice->lens : candidates[0]);
    report.choices.push_back(std::move(choice));
  }
  report.calibration = calibrate_cameras(input);
  try {
    report.halves = compare_halves(input);
  } catch (const InputError& error) {
    report.remarks.push_back(fmt::format("no comparison of halves: {}", error.what()));
  }
  find_suspicious_views(report);
  find_missing_views(report);
  if (!o.out.empty()) write_result(report, o.out);
  if (o.json) {
    app::print("{}\n", json_text(cameras_json(report), 2));
  } else if (!o.quiet) {
    app::print("{}", cameras_text(report));
  }
  return interrupt.requested() ? Interrupt::kExitCode : 0;
}

}  // namespace

Action declare_calibrate_cameras(CLI::App& parser) {
  const auto o = std::make_shared<CamerasOptions>();
  o->threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  parser.add_option("RECORDING", o->recordings, "Recordings of the target, by the same cameras")
      ->required()
      ->type_name("");
  parser.add_option("--target", o->target, "File of the target (docs/calibration.md)")
      ->required()
      ->type_name("FILE");
  parser
      .add_option("--lens", o->lens,
                  "Lens model, or several of which views that took no part choose the best, as "
                  "radtan,radtan:8,ds (default auto: the common ones)")
      ->type_name("MODELS");
  parser.add_option("--every", o->every, "Search one of so many frames (default 1)")
      ->check(CLI::Range(1, 1000000))
      ->type_name("N");
  parser.add_option("--threads", o->threads, "Images searched in parallel (default: one per core)")
      ->check(CLI::Range(1, 256))
      ->type_name("N");
  parser.add_flag("--from-nothing", o->from_nothing,
                  "Do not begin at the lens that the recording states");
  parser.add_option("-o,--out", o->out, "Folder for calibration.yaml, cameras.json, corners.csv")
      ->check(require_path)
      ->type_name("FOLDER");
  parser.add_flag("--json", o->json, "Print the content of cameras.json");
  parser.add_flag("--quiet", o->quiet, "Print nothing but errors");
  return [o] { return calibrate(*o); };
}

}  // namespace chasles::app
