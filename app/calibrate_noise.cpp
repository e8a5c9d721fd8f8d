#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/recording.hpp>

#include "calibrate_commands.hpp"
#include "print.hpp"

namespace chasles::app {
namespace {

int calibrate(const std::filesystem::path& path) {
  const Recording recording = read_recording(path);
  if (recording.imu.size() < 2) {
    throw InputError(fmt::format("{}: found {} IMU samples, expected a recording with an IMU",
                                 path.string(), recording.imu.size()));
  }
  const double seconds = to_seconds(recording.imu.back().time - recording.imu.front().time);
  app::print("{}: {} IMU samples in {:.1f} s\n", recording.name, recording.imu.size(), seconds);
  return 0;
}

}  // namespace

Action declare_calibrate_noise(CLI::App& parser) {
  const auto recording = std::make_shared<std::filesystem::path>();
  parser.add_option("RECORDING", *recording, "Recording with an IMU")->required()->type_name("");
  return [recording] { return calibrate(*recording); };
}

}  // namespace chasles::app
