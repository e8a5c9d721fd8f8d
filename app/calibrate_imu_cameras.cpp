#include <algorithm>
#include <iterator>
#include <memory>

#include <CLI/CLI.hpp>
#include <Eigen/LU>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/cameras_report.hpp>
#include <chasles/calibrate/cross_validation.hpp>
#include <chasles/calibrate/inertial_report.hpp>
#include <chasles/calibrate/target_images.hpp>
#include <chasles/calibration/foreign_writers.hpp>
#include <chasles/calibration/kalibr.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/recording/calibration_to_write.hpp>
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
                                 .imu = recording.imu,
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

// What is estimated corrects samples that the recording's own intrinsics corrected; without
// g-sensitivity.
ImuIntrinsics composed(const ImuCorrection& correction, const ImuIntrinsics& stated) {
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d force = I + correction.force, rate = I + correction.rate;
  return {.force = force * stated.force,
          .rate = rate * stated.rate,
          .rate_of_force = rate * stated.rate_of_force * force.inverse(),
          .force_bias = force * stated.force_bias,
          .rate_bias = rate * stated.rate_bias};
}

// The files of all programs, on the base of what the recording states.
void write_files(const ImuCamerasOptions& o, const Recording& recording,
                 const std::vector<Camera>& cameras, const std::vector<double>& time_offsets,
                 const ImuCorrection& imu, const nlohmann::ordered_json& json,
                 std::vector<std::string>& remarks) {
  CalibrationToWrite calibration =
      find_calibration_to_replace(o.views.recordings.front()).calibration;
  if (!o.imu_noise.empty()) calibration.imu_noise = recording.imu_noise;
  calibration.cameras = cameras;
  calibration.time_offsets.resize(cameras.size(), 0);
  for (std::size_t c = 0; c < cameras.size(); ++c) calibration.time_offsets[c] += time_offsets[c];
  if (!imu.parameters().isZero(0)) {
    calibration.imu_intrinsics =
        composed(imu, calibration.imu_intrinsics.value_or(ImuIntrinsics{}));
  }
  if (calibration.imu_rate == 0 && recording.imu.size() > 1) {  // as the samples have it
    calibration.imu_rate = static_cast<double>(recording.imu.size() - 1) /
                           to_seconds(recording.imu.back().time - recording.imu.front().time);
  }
  calibration.remark = fmt::format("Made by `chasles calibrate imu-cameras` from {}.",
                                   o.views.recordings.front().string());
  const WrittenCalibration written = write_all(calibration, o.out);
  remarks.insert(remarks.end(), written.left_out.begin(), written.left_out.end());
  replace_file(o.out / "imu-cameras.json", json_text(json, 2) + "\n");
}

int calibrate_with_target(const ImuCamerasOptions& o, const Interrupt& interrupt) {
  std::vector<std::string> remarks;
  Recording recording = read_target_recording(o.views.recordings.front());
  if (!o.imu_noise.empty()) recording.imu_noise = read_kalibr_imu(o.imu_noise).imu_noise;
  InertialCalibrationInput input = inertial_input(o, recording);
  gather_views(o.views, recording, interrupt, input.cameras, remarks);
  choose_lenses(input.cameras, std::vector(input.cameras.cameras.size(), candidate_lenses(o.views)),
                o.views.from_nothing);
  const InertialCalibration found = calibrate_inertial(input);
  std::vector<std::string> missing = missing_motion(input, found);
  std::ranges::move(missing_views(input.cameras, found.views), std::back_inserter(missing));
  for (std::string& sentence : contradictions(found)) remarks.push_back(std::move(sentence));
  if (std::string few = few_pieces(found.pieces); !few.empty()) remarks.push_back(std::move(few));
  const nlohmann::ordered_json json = inertial_json(found, missing, remarks);
  if (!o.out.empty()) {
    write_files(o, recording, found.cameras, found.time_offsets, found.imu, json, remarks);
    replace_file(o.out / "run.yaml", run_settings(found));
    replace_file(o.out / "page.html", cameras_page(json, page_views(found.views)));
  }
  if (o.json) {
    app::print("{}\n", json_text(json, 2));
  } else if (!o.views.quiet) {
    app::print("{}", inertial_text(found, missing, remarks));
  }
  return interrupt.requested() ? Interrupt::kExitCode : 0;
}

std::string motion_text(const MotionCalibration& found) {
  std::string text =
      fmt::format("{:<28}{:>14}{:>14}{:>12}\n", "parameter", "stated", "estimate", "sigma");
  for (const nlohmann::ordered_json& one : found.parameters) {
    const std::string unit = one.value("unit", "");
    text += fmt::format("{:<28}{:>14.6g}{:>14.6g}{:>12.3g} {}\n", one.at("name").get<std::string>(),
                        one.at("stated").get<double>(), one.at("estimate").get<double>(),
                        one.at("sigma").get<double>(), unit);
  }
  for (const std::string& remark : found.remarks) text += "- " + remark + "\n";
  return text;
}

int calibrate_without_target(const ImuCamerasOptions& o, const Interrupt& interrupt) {
  SessionOptions options;
  options.input.recording = o.views.recordings.front();
  options.quiet = o.views.quiet;
  Recording recording = read_input(options.input);
  MotionCalibration found = calibrate_from_motion(options, recording, o.views.from_nothing,
                                                  [&] { return interrupt.requested(); });
  const nlohmann::ordered_json json = {{"parameters", found.parameters},
                                       {"remarks", found.remarks}};
  if (!o.out.empty()) {
    write_files(o, recording, found.cameras,
                std::vector<double>(found.cameras.size(), found.time_offset), {}, json,
                found.remarks);
  }
  if (o.json) {
    app::print("{}\n", json_text(json, 2));
  } else if (!o.views.quiet) {
    app::print("{}", motion_text(found));
  }
  return interrupt.requested() ? Interrupt::kExitCode : 0;
}

void check_options(const ImuCamerasOptions& o) {
  check_is_new(o.out);
  candidate_lenses(o.views);
  if (!o.views.target.empty()) return;
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
  const Interrupt interrupt;
  return o.views.target.empty() ? calibrate_without_target(o, interrupt)
                                : calibrate_with_target(o, interrupt);
}

}  // namespace

Action declare_calibrate_imu_cameras(CLI::App& parser) {
  const auto o = std::make_shared<ImuCamerasOptions>();
  o->views.follows_target = true;
  declare_views(parser, o->views, false);
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
