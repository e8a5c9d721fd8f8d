#pragma once

#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include <chasles/lie/truth_pairing.hpp>

namespace chasles {

/// Options for the comparison of an estimate with its truth; those not given are empty.
struct TruthOptions {
  std::string pairing;            ///< "interpolate", "nearest"
  std::optional<double> max_gap;  ///< [s]
  std::string level;              ///< "auto", "yes", "no"
  std::string time_offset;        ///< added to the truth's times: "auto", or seconds
  std::string frame;              ///< whose poses the truth has: "imu", "cam0", …, or a file
  std::optional<double> scale;    ///< metres in the truth's unit
  bool inverse = false;           ///< its poses are imu_T_world
  std::string errors;             ///< constants to estimate and marginalise: "none", "auto"
};

/// The pairing with the given options replaced. Throws UsageError for an unknown name.
TruthPairing pairing_from(const TruthOptions& options, TruthPairing pairing = {});

/// Whether the z axis of the truth's world points up: as --truth-level gives it; with `auto` as the
/// recording states it (`stated`), or else unless the truth begins at the identity. Throws
/// UsageError for an unknown name.
bool is_truth_level(const TruthOptions& options, std::optional<bool> stated,
                    const Trajectory& truth);

/// Whether the clock of the truth is to be estimated (--truth-time-offset auto).
bool is_offset_auto(const TruthOptions& options);

/// The stated offset [s]; 0 with `auto` or without the option. Throws UsageError for another text.
double stated_offset(const TruthOptions& options);

/// Whether the constant errors of the truth are to be estimated (--truth-errors auto). Throws
/// UsageError for another text than auto or none.
bool are_errors_auto(const TruthOptions& options);

/// Throws UsageError if --truth-level is not `auto`, for an estimate without a vertical.
void check_level_is_auto(const TruthOptions& options);

/// One sentence for the user on a tilt [deg] that was removed.
std::string tilt_remark(double degrees);

/// The fields `pairing` and `max_truth_gap` of summary.json.
nlohmann::ordered_json pairing_json(const TruthPairing& pairing);

}  // namespace chasles
