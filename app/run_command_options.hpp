#pragma once

#include <filesystem>
#include <vector>

#include <chasles/session/session_options.hpp>

#include "live_view.hpp"
#include "thresholds.hpp"

namespace CLI {
class App;
}

namespace chasles::app {

/// The options of the command `run`.
struct RunCommandOptions : SessionOptions {
  std::filesystem::path output;
  bool json = false;
  LiveOptions live;
  std::vector<Threshold> thresholds = run_thresholds();
};

/// Adds them to the parser of the command, with the help on settings. `options` must outlive it.
void declare_run_options(CLI::App& parser, RunCommandOptions& options);

}  // namespace chasles::app
