#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace CLI {
class App;
}

namespace chasles::app {

/// Limit of a figure. The command ends with exit code 5 if the figure misses it.
struct Threshold {
  std::string option;  ///< on the command line
  std::string figure;  ///< name in the summary
  std::string unit, meaning;
  bool below = true;  ///< the figure must be below the limit; false: above
  bool needs_truth = true;
  /// Limit where another option is given, and the figure has a value.
  std::optional<double> beside{};
  std::optional<double> limit{};  ///< empty: option not given
};

/// Thresholds of `evaluate`: figures that need a truth, and the coverage.
std::vector<Threshold> truth_thresholds();
/// All thresholds of a run: those above, and those of coverage, consistency and speed.
std::vector<Threshold> run_thresholds();

/// Adds the options; `thresholds` must outlive the parser.
void add_options(CLI::App& parser, std::vector<Threshold>& thresholds);

/// The first given threshold that needs a truth; null: none.
const Threshold* needs_truth(const std::vector<Threshold>& thresholds);

/// One sentence for each missed threshold. A figure without a value misses its threshold.
std::vector<std::string> missed(const std::vector<Threshold>& thresholds,
                                const nlohmann::ordered_json& figures);

}  // namespace chasles::app
