#include <charconv>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/eval/truth_tilt.hpp>
#include <chasles/session/truth_options.hpp>

namespace chasles {

bool is_offset_auto(const TruthOptions& options) { return options.time_offset == "auto"; }

bool are_errors_auto(const TruthOptions& options) {
  if (options.errors == "auto") return true;
  if (options.errors.empty() || options.errors == "none") return false;
  throw UsageError(
      fmt::format("--truth-errors: found '{}', expected auto or none", options.errors));
}

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

}  // namespace chasles
