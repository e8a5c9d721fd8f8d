#pragma once

#include <functional>
#include <span>

namespace CLI {
class App;
}

namespace chasles::app {

/// What a subcommand does once its options are read; returns the exit code. Throws chasles::Error.
using Action = std::function<int()>;

/// A subcommand. A new one is a file with a `declare` function and a line in subcommands().
struct Subcommand {
  const char* name;
  const char* description;
  /// Declares the options on the parser, which the action will find filled in.
  Action (*declare)(CLI::App& parser);
};

std::span<const Subcommand> subcommands();

// One .cpp each.
Action declare_run(CLI::App& parser);
Action declare_check(CLI::App& parser);
Action declare_simulate(CLI::App& parser);
Action declare_compare(CLI::App& parser);
Action declare_montecarlo(CLI::App& parser);
Action declare_evaluate(CLI::App& parser);
Action declare_report(CLI::App& parser);
Action declare_view(CLI::App& parser);
Action declare_export(CLI::App& parser);

}  // namespace chasles::app
