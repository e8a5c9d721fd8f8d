#include "truth_options.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/error.hpp>

#include "options.hpp"

namespace chasles::app {

void declare_pairing(CLI::App& parser, TruthOptions& options, const std::string& group) {
  parser
      .add_option(
          "--pairing", options.pairing,
          "interpolate (default): the truth at the time of each estimate; nearest: pairs of "
          "the poses that are nearest in time")
      ->type_name("NAME")
      ->group(group);
  add_number(
      parser, "--max-truth-gap", options.max_gap, "S",
      fmt::format("Interpolate the truth between poses at most this far apart (default: {:g})",
                  to_seconds(kLongestTruthGap)),
      0, kMostTruthGap)
      ->group(group);
}

TruthPairing pairing_from(const TruthOptions& options, TruthPairing pairing) {
  if (!options.pairing.empty()) {
    const auto choice = choice_of<Pairing>(options.pairing);
    if (!choice) {
      throw UsageError(fmt::format("--pairing: found '{}', expected {}", options.pairing,
                                   fmt::join(kChoiceNames<Pairing>, " or ")));
    }
    pairing.pairing = *choice;
  }
  if (options.max_gap) pairing.longest_gap = from_seconds(*options.max_gap);
  return pairing;
}

nlohmann::ordered_json pairing_json(const TruthPairing& pairing) {
  return {{"pairing", name_of(pairing.pairing)},
          {"max_truth_gap", to_seconds(pairing.longest_gap)}};
}

}  // namespace chasles::app
