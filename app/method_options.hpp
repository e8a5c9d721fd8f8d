#pragma once

#include <string>

#include <chasles/session/session_options.hpp>

namespace CLI {
class App;
}

namespace chasles::app {

/// Adds the options of how recordings are estimated: estimator, settings, start. `estimator`: what
/// the help calls the default. `options` must outlive the parser.
void declare_method(CLI::App& parser, SessionOptions& options,
                    const std::string& estimator = "filter");

/// The settings of --set and --config, for the end of the help.
std::string method_help();

}  // namespace chasles::app
