#pragma once

#include <chasles/check/check_report.hpp>
#include <chasles/eval/truth_reference.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles {

/// Adds to a check what the IMU alone shows of a truth: the times of its attitudes (gyroscope) and
/// of its positions (accelerometer), the axes of its body, its tilt, and its heading against its
/// positions, each with its sigma. Notes what differs from zero by 5 sigmas. `start`: offset of the
/// truth's clock [s], as examine_truth() finds it.
void report_truth_clocks(const Recording& recording, const TruthReference& gyroscope, double start,
                         CheckReport& report);

}  // namespace chasles
