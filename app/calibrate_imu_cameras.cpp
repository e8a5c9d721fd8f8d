#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/inertial_files.hpp>
#include <chasles/calibrate/target_images.hpp>
#include <chasles/calibration/kalibr.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/recording/calibration_to_write.hpp>
#include <chasles/session/interrupt.hpp>
#include <chasles/session/motion_calibration.hpp>
#include <chasles/session/recording_input.hpp>
#include <chasles/target/target_file.hpp>

#include "calibrate_commands.hpp"
#include "calibrate_views.hpp"
#include "follow_target.hpp"
#include "options.hpp"
#include "print.hpp"

namespace chasles::app {
namespace {

namespace fs = std::filesystem;

struct ImuCamerasOptions {
  ViewsOptions views;
  fs::path out, imu_noise;
  std::optional<double> gravity;
  bool rolling = false, exact_imu = false, json = false;
};

InertialCalibrationInput inertial_input(const ImuCamerasOptions& o, const Recording& recording) {
  if (recording.imu.empty()) {
    throw InputError(
        fmt::format("{}: has no samples of an IMU, expected a table of them (imu.csv, "
                    "imu0/data.csv) in the folder of the recording",
                    recording.name));
  }
  if (!recording.imu_noise) {
    throw InputError(
        fmt::format("{}: states no noise of the IMU: expected it in its calibration, in an "
                    "imu.yaml of Kalibr's "
                    "form, or by --imu-noise FILE (`chasles calibrate noise` measures it)",
                    recording.name));
  }
  InertialCalibrationInput input{.cameras = input_for(read_target(o.views.target)),
                                 .imu = {},
                                 .convention = recording.imu_convention,
                                 .noise = *recording.imu_noise,
                                 .gravity = o.gravity.value_or(kStandardGravity),
                                 .has_readout = o.rolling,
                                 .has_imu_errors = !o.exact_imu};
  for (const Camera& camera : recording.cameras) {
    input.has_readout |= camera.shutter.is_rolling();
  }
  return input;
}

// What the recording states, for the files of all programs.
CalibrationToWrite stated_calibration(const ImuCamerasOptions& o, const Recording& recording) {
  CalibrationToWrite calibration =
      find_calibration_to_replace(o.views.recordings.front()).calibration;
  if (!o.imu_noise.empty()) calibration.imu_noise = recording.imu_noise;
  if (calibration.imu_rate == 0 && recording.imu.size() > 1) {  // as the samples have it
    calibration.imu_rate = static_cast<double>(recording.imu.size() - 1) /
                           to_seconds(recording.imu.back().time - recording.imu.front().time);
  }
  std::string names;
  for (const fs::path& path : o.views.recordings) {
    names += (names.empty() ? "" : ", ") + path.string();
  }
  calibration.remark = fmt::format("Made by `chasles calibrate imu-cameras` from {}.", names);
  return calibration;
}

// Views and samples of all recordings: what was found until Ctrl-C counts. Returns the first one.
Recording gather_recordings(const ImuCamerasOptions& o, const Interrupt& interrupt,
                            InertialReport& report) {
  std::optional<Recording> first;
  for (const fs::path& path : o.views.recordings) {
    Recording recording = read_target_recording(path);
    if (!o.imu_noise.empty()) recording.imu_noise = read_kalibr_imu(o.imu_noise).imu_noise;
    if (!first) report.input = inertial_input(o, recording);
    CamerasInput of_this = input_for(read_target(o.views.target));
    of_this.cameras = report.input.cameras.cameras;
    gather_views(o.views, recording, interrupt, of_this, report.remarks);
    report.input.cameras.cameras = of_this.cameras;
    add_recording(report.input, std::move(of_this.views), recording.imu);
    if (!first) {
      first = std::move(recording);
    } else {
      const fs::path& of_first = o.views.recordings.front();
      check_same_rig(of_first.string(), find_calibration_to_replace(of_first).calibration,
                     path.string(), find_calibration_to_replace(path).calibration);
    }
    if (interrupt.requested()) break;
  }
  return std::move(*first);
}

int calibrate_with_target(const ImuCamerasOptions& o) {
  InertialReport report;
  std::optional<Recording> first;
  bool is_interrupted = false;
  {
    const Interrupt interrupt;
    first = gather_recordings(o, interrupt, report);
    is_interrupted = interrupt.requested();
  }
  {
    const EndAtOnce nothing_is_written({});
    const std::size_t cameras = report.input.cameras.cameras.size();
    calibrate_with_report(report, std::vector(cameras, candidate_lenses(o.views)),
                          o.views.from_nothing, o.views.threads);
  }
  if (!o.out.empty()) {
    write_inertial(report, stated_calibration(o, *first), o.out);
    replace_file(o.out / "page.html",
                 cameras_page(inertial_json(report), page_views(report.calibration.views)));
  }
  if (o.json) {
    app::print("{}\n", json_text(inertial_json(report), 2));
  } else if (!o.views.quiet) {
    app::print("{}", inertial_text(report));
  }
  return is_interrupted ? Interrupt::kExitCode : 0;
}

int calibrate_without_target(const ImuCamerasOptions& o) {
  const Interrupt interrupt;
  SessionOptions options;
  options.input.recording = o.views.recordings.front();
  options.quiet = o.views.quiet;
  Recording recording = read_input(options.input);
  MotionCalibration found = calibrate_from_motion(options, recording, o.views.from_nothing,
                                                  [&] { return interrupt.requested(); });
  if (!o.out.empty()) {
    const std::vector<double> offsets(found.cameras.size(), found.time_offset);
    const WrittenCalibration written =
        write_all(with_found(stated_calibration(o, recording), found.cameras, offsets, {}), o.out);
    found.remarks.insert(found.remarks.end(), written.left_out.begin(), written.left_out.end());
    replace_file(o.out / "imu-cameras.json", json_text(motion_json(found), 2) + "\n");
  }
  if (o.json) {
    app::print("{}\n", json_text(motion_json(found), 2));
  } else if (!o.views.quiet) {
    app::print("{}", motion_text(found));
  }
  return interrupt.requested() ? Interrupt::kExitCode : 0;
}

void check_options(const ImuCamerasOptions& o) {
  check_is_new(o.out);
  candidate_lenses(o.views);
  check_different(o.views.recordings);
  if (!o.views.target.empty()) return;
  if (o.views.recordings.size() > 1) {
    throw UsageError(fmt::format("found {} recordings without --target, expected one",
                                 o.views.recordings.size()));
  }
  if (o.views.lens != "auto" || o.views.every != 1 || o.gravity || o.rolling || o.exact_imu ||
      o.views.live || !o.imu_noise.empty()) {
    throw UsageError(
        "--lens, --every, --gravity, --rolling, --exact-imu, --imu-noise and --live need --target: "
        "without it the recording is estimated as `chasles run` does");
  }
}

int calibrate_imu_cameras(ImuCamerasOptions o) {
  check_options(o);
  const auto live = follow_target(o.views);
  return o.views.target.empty() ? calibrate_without_target(o) : calibrate_with_target(o);
}

}  // namespace

Action declare_calibrate_imu_cameras(CLI::App& parser) {
  const auto o = std::make_shared<ImuCamerasOptions>();
  o->views.follows_target = true;
  declare_views(parser, o->views, true);
  add_number(parser, "--gravity", o->gravity, "m/s^2",
             "Magnitude of gravity where the recording was made (default 9.80665)", 9.7, 9.9);
  parser
      .add_option(
          "--imu-noise", o->imu_noise,
          "Noise of the IMU, as imu.yaml of `chasles calibrate noise` or of Kalibr (default: "
          "what the recording states)")
      ->type_name("FILE");
  parser.add_flag("--rolling", o->rolling,
                  "Estimate the readout times of the cameras, also where none is stated");
  parser.add_flag("--exact-imu", o->exact_imu,
                  "Take scales and axes of the IMU as they are, and do not estimate them");
  parser
      .add_option("-o,--output", o->out,
                  "Folder for calibration.yaml, run.yaml, the files of other programs, "
                  "imu-cameras.json and page.html")
      ->check(require_path)
      ->type_name("DIR");
  parser.add_flag("--json", o->json, "Print the content of imu-cameras.json");
  return [o] { return calibrate_imu_cameras(*o); };
}

}  // namespace chasles::app
