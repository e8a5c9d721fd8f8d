#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace CLI {
class App;
}

namespace chasles::app {

/// A figure that must not be missed; the command ends with exit code 5 where it is.
struct Threshold {
  std::string option;  ///< of the command line
  std::string figure;  ///< of the summary
  std::string unit, meaning;
  bool below = true;  ///< the figure must be below the limit; false: above it
  bool needs_truth = true;
  std::optional<double> limit{};  ///< none: not asked for
};

/// Those of every evaluation, and those that only a run has.
std::vector<Threshold> truth_thresholds();
std::vector<Threshold> run_thresholds();

/// Adds the options; `thresholds` must outlive the parser.
void add_options(CLI::App& parser, std::vector<Threshold>& thresholds);

/// The first one asked for that cannot be answered without a truth; null: none.
const Threshold* needs_truth(const std::vector<Threshold>& thresholds);

/// A sentence for every threshold that the figures miss. A figure without a value misses.
std::vector<std::string> missed(const std::vector<Threshold>& thresholds,
                                const nlohmann::ordered_json& figures);

}  // namespace chasles::app
