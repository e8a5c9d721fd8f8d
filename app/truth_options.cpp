#include "truth_options.hpp"

#include <charconv>
#include <cmath>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/eval/truth_tilt.hpp>

#include "options.hpp"

namespace chasles::app {

void declare_truth(CLI::App& parser, TruthOptions& options, const std::string& group) {
  parser
      .add_option(
          "--pairing", options.pairing,
          "interpolate (default): the truth at the time of each estimate; nearest: pairs of "
          "the poses that are nearest in time")
      ->type_name(fmt::format("{}", fmt::join(kChoiceNames<Pairing>, "|")))
      ->group(group);
  add_number(
      parser, "--max-truth-gap", options.max_gap, "S",
      fmt::format("Interpolate the truth between poses at most this far apart (default: {:g})",
                  to_seconds(kLongestTruthGap)),
      0, kMostTruthGap)
      ->group(group);
  parser
      .add_option("--truth-level", options.level,
                  "Whether the z axis of the truth's world points up. no: remove its tilt, and "
                  "report it; auto (default): as truth_level in calibration.yaml, or else no where "
                  "the truth begins at the identity. For estimates with an IMU")
      ->type_name("auto|yes|no")
      ->group(group);
  parser
      .add_option("--truth-time-offset", options.time_offset,
                  "Seconds to add to the truth's times; auto: as its motion against the estimate's "
                  "shows it")
      ->type_name("S|auto")
      ->group(group);
  parser
      .add_option("--truth-frame", options.frame,
                  "Whose poses the truth has: imu (default), cam0 (by the calibration), or a file "
                  "with imu_T_truth, four rows of four numbers (docs/evaluation.md)")
      ->type_name("cam0|imu|FILE")
      ->group(group);
  add_number(parser, "--truth-scale", options.scale, "X",
             "Multiply the truth's positions by this: 0.001 for millimetres", 1e-9, 1e9)
      ->group(group);
  parser.add_flag("--truth-inverse", options.inverse, "The truth's poses are imu_T_world")
      ->group(group);
}

bool is_offset_auto(const TruthOptions& options) { return options.time_offset == "auto"; }

double stated_offset(const TruthOptions& options) {
  const std::string& text = options.time_offset;
  if (text.empty() || text == "auto") return 0;
  constexpr double kMost = 4e9;  // since 1970
  double seconds = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), seconds);
  const bool whole = error == std::errc() && stop == text.data() + text.size();
  if (whole && std::abs(seconds) <= kMost) return seconds;
  throw UsageError(fmt::format(
      "--truth-time-offset: found '{}', expected auto or seconds, at most {:g}", text, kMost));
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

bool is_truth_level(const TruthOptions& options, std::optional<bool> stated,
                    const Trajectory& truth) {
  if (options.level == "yes") return true;
  if (options.level == "no") return false;
  if (!options.level.empty() && options.level != "auto") {
    throw UsageError(
        fmt::format("--truth-level: found '{}', expected auto, yes or no", options.level));
  }
  return stated.value_or(!begins_at_identity(truth));
}

void check_level_is_auto(const TruthOptions& options) {
  if (options.level.empty() || options.level == "auto") return;
  throw UsageError(
      "--truth-level is for a run with an IMU: others have no vertical, and their worlds are "
      "aligned by the first pose");
}

std::string tilt_remark(double degrees) {
  return fmt::format(
      "the z axis of the truth's world is {:.2f} deg off the vertical of the estimate: removed "
      "before the comparison (--truth-level yes keeps it)",
      degrees);
}

nlohmann::ordered_json pairing_json(const TruthPairing& pairing) {
  return {{"pairing", name_of(pairing.pairing)},
          {"max_truth_gap", to_seconds(pairing.longest_gap)}};
}

}  // namespace chasles::app
