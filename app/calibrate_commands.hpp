#pragma once

#include <span>

#include "subcommands.hpp"

namespace chasles::app {

/// The subcommands of `chasles calibrate`. A new one needs a file app/calibrate_NAME.cpp with a
/// `declare` function and a line in calibrate_commands().
std::span<const Subcommand> calibrate_commands();

// Each has its own .cpp.
Action declare_calibrate_cameras(CLI::App& parser);
Action declare_calibrate_imu_cameras(CLI::App& parser);
Action declare_calibrate_convert(CLI::App& parser);
Action declare_calibrate_noise(CLI::App& parser);
Action declare_calibrate_target(CLI::App& parser);

}  // namespace chasles::app
