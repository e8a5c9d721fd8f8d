#include "program.hpp"

#include <exception>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chasles/base/error.hpp>
#include <chasles/base/interruption.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/session/fault.hpp>

#include "options.hpp"
#include "print.hpp"
#include "subcommands.hpp"

namespace chasles::app {
namespace {

constexpr const char* kExitCodes =
    "Exit codes: 0 ok, 1 usage, 2 bad input, 3 could not initialise, 4 diverged,\n"
    "5 a requested threshold was missed, 70 internal error, 130 interrupted.";

// The command and the subcommands that were chosen, outermost first.
std::vector<const CLI::App*> chosen_commands(const CLI::App& parser) {
  std::vector<const CLI::App*> chosen = {&parser};
  for (auto below = parser.get_subcommands(); !below.empty();
       below = chosen.back()->get_subcommands()) {
    chosen.push_back(below.front());
  }
  return chosen;
}

// CLI11 prints a superfluous empty line before each group of options.
std::string without_double_gaps(std::string text) {
  for (std::size_t at; (at = text.find("\n\n\n")) != std::string::npos;) text.erase(at, 1);
  return text;
}

std::string complaint(const CLI::App& parser, const CLI::ParseError& error) {
  const auto rest = parser.remaining(true);
  if (rest.empty()) return error.what();
  return fmt::format("'{}' is not known here{}", rest.front(),
                     did_you_mean(rest.front(), known_words(*chosen_commands(parser).back())));
}

int rejected(const CLI::App& parser, const CLI::ParseError& error) {
  if (error.get_exit_code() != 0) {
    std::string command;
    for (const CLI::App* each : chosen_commands(parser)) command += each->get_name() + " ";
    spdlog::error("{} (see {}--help)", complaint(parser, error), command);
    return static_cast<int>(ExitCode::kUsage);
  }
  const bool help = dynamic_cast<const CLI::CallForHelp*>(&error) != nullptr;
  app::print("{}\n", help ? without_double_gaps(parser.help()) : error.what());
  flush_stdout();
  return static_cast<int>(ExitCode::kOk);
}

int parse_and_run(int argc, char** argv) {
  CLI::App parser(CHASLES_DESCRIPTION, "chasles");
  parser.set_version_flag("--version", "chasles " CHASLES_VERSION);
  parser.footer(kExitCodes);
  parser.require_subcommand(1);
  Action action;
  for (const Subcommand& command : subcommands()) {
    CLI::App* sub = parser.add_subcommand(command.name, command.description);
    sub->parse_complete_callback([&action, perform = command.declare(*sub)] { action = perform; });
  }
  try {
    parser.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return rejected(parser, error);
  }
  const int code = action();
  flush_stdout();
  return code;
}

}  // namespace

int program(int argc, char** argv) {
  report_file_limit();
  log_to_stderr("chasles");
  try {
    return parse_and_run(argc, argv);
  } catch (const Interrupted&) {  // of the Python package
    throw;
  } catch (const std::exception& error) {
    const Fault fault = fault_of(error);
    spdlog::error("{}", fault.sentence);
    return fault.code;
  }
}

}  // namespace chasles::app
