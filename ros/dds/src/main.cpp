#include <exception>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chasles/base/error.hpp>

#include "bridge.hpp"
#include "fault.hpp"
#include "interrupt.hpp"
#include "print.hpp"

namespace {

int parse_and_run(int argc, char** argv) {
  CLI::App parser(
      "Visual-inertial SLAM on the topics of ROS 2, over DDS and without ROS 2 (docs/ros2.md)",
      "chasles_dds");
  parser.set_version_flag("--version", "chasles_dds " CHASLES_VERSION);
  chasles::bridge::BridgeOptions options;
  chasles::bridge::declare_bridge_options(parser, options);
  try {
    parser.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help, --version
    return parser.exit(asked);
  } catch (const CLI::ParseError& error) {
    throw chasles::UsageError(fmt::format("{} (see chasles_dds --help)", error.what()));
  }
  if (options.quiet) spdlog::set_level(spdlog::level::err);
  const chasles::app::Interrupt interrupt;
  chasles::bridge::run_bridge(options, [&] { return interrupt.requested(); });
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  chasles::app::report_file_limit();
  chasles::app::log_to_stderr("chasles_dds", true);
  try {
    return parse_and_run(argc, argv);
  } catch (const std::exception& error) {
    const chasles::app::Fault fault = chasles::app::fault_of(error);
    spdlog::error("{}", fault.sentence);
    return fault.code;
  }
}
