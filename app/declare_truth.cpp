#include "declare_truth.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

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

void declare_truth_errors(CLI::App& parser, TruthOptions& options, const std::string& group) {
  parser
      .add_option(
          "--truth-errors", options.errors,
          "auto: estimate constant errors of the truth (time of its positions, rotations of "
          "body and world) with their sigmas, and give the figures without them, too; none "
          "(default)")
      ->type_name("auto|none")
      ->group(group);
}

}  // namespace chasles::app
