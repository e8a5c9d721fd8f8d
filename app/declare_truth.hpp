#pragma once

#include <string>

#include <chasles/session/truth_options.hpp>

namespace CLI {
class App;
}

namespace chasles::app {

/// Adds --pairing, --max-truth-gap, --truth-level, --truth-time-offset, --truth-frame,
/// --truth-scale and --truth-inverse; `options` must outlive the parser.
void declare_truth(CLI::App& parser, TruthOptions& options, const std::string& group);

/// Adds --truth-errors.
void declare_truth_errors(CLI::App& parser, TruthOptions& options, const std::string& group);

}  // namespace chasles::app
