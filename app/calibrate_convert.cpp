#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/foreign_writers.hpp>
#include <chasles/recording/calibration_to_write.hpp>

#include "calibrate_commands.hpp"
#include "calibrate_views.hpp"
#include "options.hpp"
#include "print.hpp"

namespace chasles::app {
namespace {

namespace fs = std::filesystem;

struct ConvertOptions {
  fs::path input, output;
  double imu_rate = 0;  ///< [Hz]; 0: not given
  bool quiet = false;
};

int convert(const ConvertOptions& o) {
  check_is_new(o.output);
  CalibrationFound found = find_calibration_to_write(o.input, o.imu_rate);
  found.calibration.remark =
      fmt::format("Made by `chasles calibrate convert` from {}.", o.input.string());
  const WrittenCalibration written = write_all(found.calibration, o.output);
  if (o.quiet) return 0;
  for (const fs::path& file : written.files) app::print("{}\n", file.string());
  for (const std::string& remark : found.remarks) app::print("- {}\n", remark);
  for (const std::string& sentence : written.left_out) app::print("- {}\n", sentence);
  return 0;
}

}  // namespace

Action declare_calibrate_convert(CLI::App& parser) {
  const auto o = std::make_shared<ConvertOptions>();
  parser
      .add_option(
          "RECORDING", o->input,
          "Recording, or file or folder with a calibration: calibration.yaml, or of Kalibr, "
          "OpenVINS, EuRoC, Basalt, VINS, ORB-SLAM3 or depthai")
      ->required()
      ->type_name("");
  parser
      .add_option("-o,--output", o->output,
                  "New folder for calibration.yaml and the folders kalibr, ros, opencv, basalt and "
                  "colmap (docs/calibration-conventions.md)")
      ->required()
      ->check(require_path)
      ->type_name("DIR");
  parser
      .add_option("--imu-rate", o->imu_rate,
                  "Rate of the IMU [Hz], where the input does not state it: Kalibr and Basalt need "
                  "it, and so does the noise of VINS")
      ->check(CLI::Range(1e-3, 1e6))
      ->type_name("X");
  parser.add_flag("--quiet", o->quiet, "Print nothing but errors");
  return [o] { return convert(*o); };
}

}  // namespace chasles::app
