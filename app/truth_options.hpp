#pragma once

#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include <chasles/lie/truth_pairing.hpp>

namespace CLI {
class App;
}

namespace chasles::app {

/// Options for the pairing of an estimate with its truth; those not given are empty.
struct TruthOptions {
  std::string pairing;            ///< "interpolate", "nearest"
  std::optional<double> max_gap;  ///< [s]
};

/// Adds --pairing and --max-truth-gap; `options` must outlive the parser.
void declare_pairing(CLI::App& parser, TruthOptions& options, const std::string& group);

/// The pairing with the given options replaced. Throws UsageError for an unknown name.
TruthPairing pairing_from(const TruthOptions& options, TruthPairing pairing = {});

/// The fields `pairing` and `max_truth_gap` of summary.json.
nlohmann::ordered_json pairing_json(const TruthPairing& pairing);

}  // namespace chasles::app
