#include <memory>
#include <utility>

#include <CLI/CLI.hpp>

#include "calibrate_commands.hpp"

namespace chasles::app {

std::span<const Subcommand> calibrate_commands() {
  static constexpr Subcommand list[] = {
      {"cameras", "Lenses and relative poses of cameras, from views of a target",
       declare_calibrate_cameras},
      {"imu-cameras", "Cameras with their IMU: mounting, clock, readout, scales, from a target",
       declare_calibrate_imu_cameras},
      {"convert", "The calibration of a recording or program, in the files of other programs",
       declare_calibrate_convert},
      {"noise", "Noise densities and bias walks of an IMU, from a standstill or a motion",
       declare_calibrate_noise},
      {"target", "A board to print, as PDF or SVG, with the file that describes it",
       declare_calibrate_target},
  };
  return list;
}

Action declare_calibrate(CLI::App& parser) {
  parser.require_subcommand(1);
  const auto chosen = std::make_shared<Action>();
  for (const Subcommand& command : calibrate_commands()) {
    CLI::App* sub = parser.add_subcommand(command.name, command.description);
    sub->parse_complete_callback([chosen, perform = command.declare(*sub)] { *chosen = perform; });
  }
  return [chosen] { return (*chosen)(); };
}

}  // namespace chasles::app
