#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/cross_validation.hpp>
#include <chasles/calibrate/inertial_report.hpp>
#include <chasles/calibration/calibration.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/target/target_file.hpp>

#include "calibrate_commands.hpp"
#include "calibrate_views.hpp"
#include "options.hpp"
#include "print.hpp"

namespace chasles::app {
namespace {

namespace fs = std::filesystem;

struct ImuCamerasOptions {
  ViewsOptions views;
  fs::path out;
  std::optional<double> gravity;
  bool rolling = false, exact_imu = false, json = false;
};

InertialCalibrationInput inertial_input(const ImuCamerasOptions& o, const Recording& recording) {
  if (!recording.imu_noise) {
    throw InputError(fmt::format(
        "{}: states no noise of the IMU: expected it in its calibration (`chasles calibrate noise` "
        "measures it)",
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

void write_inertial(const InertialCalibration& found, const Recording& recording,
                    const nlohmann::ordered_json& json, const fs::path& folder) {
  fs::create_directories(folder);
  FolderCalibration calibration{.name = recording.name};
  calibration.cameras = found.cameras;
  calibration.imu_noise = recording.imu_noise;
  calibration.imu_range = recording.imu_range;
  calibration.imu_convention = recording.imu_convention;
  write_calibration(calibration, folder / "calibration.yaml");
  replace_file(folder / "imu-cameras.json", json_text(json, 2) + "\n");
}

int calibrate_imu_cameras(const ImuCamerasOptions& o) {
  const Interrupt interrupt;
  std::vector<std::string> remarks;
  const Recording recording = read_recording(o.views.recordings.front());
  InertialCalibrationInput input = inertial_input(o, recording);
  gather_views(o.views, recording, interrupt, input.cameras, remarks);
  const std::vector<LensForm> candidates = candidate_lenses(o.views);
  for (std::size_t c = 0; c < input.cameras.cameras.size(); ++c) {
    if (o.views.from_nothing) input.cameras.cameras[c].fx = 0;
    input.cameras.lenses.push_back(
        candidates.size() > 1 ? choose_lens(input.cameras, c, candidates).lens : candidates[0]);
  }
  const InertialCalibration found = calibrate_inertial(input);
  const std::vector<std::string> missing = missing_motion(input, found);
  const nlohmann::ordered_json json = inertial_json(found, missing, remarks);
  if (!o.out.empty()) write_inertial(found, recording, json, o.out);
  if (o.json) {
    app::print("{}\n", json_text(json, 2));
  } else if (!o.views.quiet) {
    app::print("{}", inertial_text(found, missing, remarks));
  }
  return interrupt.requested() ? Interrupt::kExitCode : 0;
}

}  // namespace

Action declare_calibrate_imu_cameras(CLI::App& parser) {
  const auto o = std::make_shared<ImuCamerasOptions>();
  declare_views(parser, o->views, false);
  add_number(parser, "--gravity", o->gravity, "m/s^2",
             "Magnitude of gravity where the recording was made (default 9.80665)", 9.7, 9.9);
  parser.add_flag("--rolling", o->rolling,
                  "Estimate the readout times of the cameras, also where none is stated");
  parser.add_flag("--exact-imu", o->exact_imu,
                  "Take scales and axes of the IMU as they are, and do not estimate them");
  parser.add_option("-o,--out", o->out, "Folder for calibration.yaml and imu-cameras.json")
      ->check(require_path)
      ->type_name("FOLDER");
  parser.add_flag("--json", o->json, "Print the content of imu-cameras.json");
  return [o] { return calibrate_imu_cameras(*o); };
}

}  // namespace chasles::app
