#pragma once

#include <functional>
#include <span>

namespace CLI {
class App;
}

namespace chasles::app {

/// Action of a subcommand after parsing; returns the exit code. Throws chasles::Error.
using Action = std::function<int()>;

/// A subcommand. A new one needs a file with a `declare` function and a line in subcommands().
struct Subcommand {
  const char* name;
  const char* description;
  /// Declares the options on the parser. The returned action uses their parsed values.
  Action (*declare)(CLI::App& parser);
};

std::span<const Subcommand> subcommands();

// Each has its own .cpp.
Action declare_run(CLI::App& parser);
Action declare_batch(CLI::App& parser);
Action declare_check(CLI::App& parser);
Action declare_calibrate(CLI::App& parser);
Action declare_simulate(CLI::App& parser);
Action declare_compare(CLI::App& parser);
Action declare_montecarlo(CLI::App& parser);
Action declare_evaluate(CLI::App& parser);
Action declare_report(CLI::App& parser);
Action declare_view(CLI::App& parser);
Action declare_export(CLI::App& parser);
Action declare_map(CLI::App& parser);
Action declare_completion(CLI::App& parser);

}  // namespace chasles::app
