#include <algorithm>
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/calibrate/cameras_report.hpp>
#include <chasles/calibrate/target_images.hpp>
#include <chasles/calibration/foreign_writers.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/report/calibration_page.hpp>
#include <chasles/session/interrupt.hpp>
#include <chasles/target/target_file.hpp>

#include "calibrate_commands.hpp"
#include "calibrate_views.hpp"
#include "follow_target.hpp"
#include "options.hpp"
#include "print.hpp"

namespace chasles::app {
namespace {

namespace fs = std::filesystem;

struct CamerasOptions {
  ViewsOptions views;
  fs::path out;
  bool json = false;
};

void write_result(CamerasReport& report, const fs::path& folder) {
  fs::create_directories(folder);
  CalibrationToWrite calibration{.name = "calibration", .cameras = report.calibration.cameras};
  calibration.remark = "Made by `chasles calibrate cameras`.";
  const WrittenCalibration written = write_all(calibration, folder);
  report.remarks.insert(report.remarks.end(), written.left_out.begin(), written.left_out.end());
  const nlohmann::ordered_json json = cameras_json(report);
  replace_file(folder / "cameras.json", json_text(json, 2) + "\n");
  replace_file(folder / "page.html", cameras_page(json, page_views(report.calibration.views)));
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

// Whether Ctrl-C ended the search for the target; what was found until then counts.
bool gather_all(const CamerasOptions& o, CamerasReport& report) {
  const Interrupt interrupt;
  CamerasInput& input = report.input;
  input = input_for(read_target(o.views.target));
  check_different(o.views.recordings);
  for (const fs::path& path : o.views.recordings) {
    const Recording recording = read_target_recording(path);
    gather_views(o.views, recording, interrupt, input, report.remarks);
  }
  return interrupt.requested();
}

int calibrate_by_views(CamerasOptions o) {
  check_is_new(o.out);
  const std::vector<LensForm> candidates = candidate_lenses(o.views);
  const auto live = follow_target(o.views);
  CamerasReport report;
  const bool is_interrupted = gather_all(o, report);
  {
    const EndAtOnce nothing_is_written({});
    calibrate_with_report(report, std::vector(report.input.cameras.size(), candidates),
                          o.views.from_nothing, o.views.threads);
  }
  if (!o.out.empty()) write_result(report, o.out);
  if (o.json) {
    app::print("{}\n", json_text(cameras_json(report), 2));
  } else if (!o.views.quiet) {
    app::print("{}", cameras_text(report));
  }
  return is_interrupted ? Interrupt::kExitCode : 0;
}

}  // namespace

Action declare_calibrate_cameras(CLI::App& parser) {
  const auto o = std::make_shared<CamerasOptions>();
  declare_views(parser, o->views, false);
  parser
      .add_option("-o,--output", o->out,
                  "Folder for calibration.yaml, the files of other programs, cameras.json, "
                  "corners.csv and page.html")
      ->check(require_path)
      ->type_name("DIR");
  parser.add_flag("--json", o->json, "Print the content of cameras.json");
  return [o] { return calibrate_by_views(*o); };
}

}  // namespace chasles::app
