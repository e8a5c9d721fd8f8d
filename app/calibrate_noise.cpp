#include <filesystem>
#include <memory>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <chasles/calibrate/noise/imu_alone.hpp>
#include <chasles/calibrate/noise/noise_calibration.hpp>
#include <chasles/calibrate/noise/noise_output.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/report/calibration_page.hpp>
#include <chasles/session/remarks.hpp>

#include "calibrate_commands.hpp"
#include "options.hpp"
#include "print.hpp"

namespace chasles::app {
namespace {

struct NoiseOptions {
  std::filesystem::path recording, folder;
  NoiseCalibrationSettings settings = {};
  bool json = false;
};

std::vector<AllanCurve> curves_of(const NoiseCalibration& calibration) {
  std::vector<AllanCurve> curves;
  if (!calibration.standstill) return curves;
  for (std::size_t i = 0; i < kImuSignals; ++i) {
    AllanCurve curve{.sensor = i < 3 ? "accelerometer" : "gyroscope",
                     .axis = std::string(1, "xyz"[i % 3]),
                     .seconds = {},
                     .deviation = {},
                     .lowest = {},
                     .highest = {},
                     .of_fit = {}};
    for (const AllanPoint& point : (*calibration.standstill)[i].allan) {
      curve.seconds.push_back(point.seconds);
      curve.deviation.push_back(point.deviation);
      curve.lowest.push_back(point.lowest);
      curve.highest.push_back(point.highest);
      curve.of_fit.push_back(point.of_fit);
    }
    curves.push_back(std::move(curve));
  }
  return curves;
}

int calibrate(const NoiseOptions& o) {
  const Recording recording = read_for_imu(o.recording);
  const RemarksOnError remarks(recording);
  const NoiseCalibration calibration = calibrate_noise(recording, o.settings);
  if (!o.folder.empty()) {
    make_folder(o.folder);
    replace_file(o.folder / "noise.json", json_text(noise_json(calibration), 2) + "\n");
    replace_file(o.folder / "imu.yaml", noise_yaml(calibration));
    replace_file(o.folder / "allan.csv", allan_csv(calibration));
    replace_file(o.folder / "page.html",
                 noise_page(noise_json(calibration), curves_of(calibration)));
  }
  app::print("{}", o.json ? json_text(noise_json(calibration), 2) + "\n" : noise_text(calibration));
  return 0;
}

}  // namespace

Action declare_calibrate_noise(CLI::App& parser) {
  const auto o = std::make_shared<NoiseOptions>();
  parser
      .add_option("RECORDING", o->recording,
                  "Recording with an IMU, or a table of its samples; best an hour of standstill")
      ->required()
      ->type_name("");
  parser
      .add_option("-o,--output", o->folder,
                  "Folder for noise.json, imu.yaml (of Kalibr and of recordings), allan.csv and "
                  "page.html")
      ->check(require_path)
      ->type_name("DIR");
  add_number(parser, "--start", o->settings.start, "S",
             "Leave out the recording before this second", 0);
  add_number(parser, "--stop", o->settings.stop, "S", "Leave out the recording after this second",
             0);
  parser.add_flag("--standstill", o->settings.all_standstill,
                  "All of it is a standstill, also where the samples scatter as in a motion");
  parser.add_flag("--json", o->json, "Print as JSON");
  return [o] { return calibrate(*o); };
}

}  // namespace chasles::app
