#include <cstdio>
#include <exception>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <chasles/error.hpp>

#include "bridge.hpp"
#include "interrupt.hpp"

namespace {

constexpr int kFault = 70;  // an internal error: EX_SOFTWARE of sysexits.h

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
  spdlog::set_default_logger(spdlog::stderr_color_mt("chasles_dds"));  // of several threads
  spdlog::set_pattern("%n: %^%l%$: %v");
  try {
    return parse_and_run(argc, argv);
  } catch (const chasles::Error& error) {
    spdlog::error("{}", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    spdlog::error("internal error, please report it: {}", error.what());
  }
  return kFault;
}
