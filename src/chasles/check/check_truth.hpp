#pragma once

#include <chasles/check/check_report.hpp>
#include <chasles/data/recording.hpp>

namespace chasles {

/// Compares the truth with the IMU: gravity must point down in the truth's world (fit_gravity), and
/// the truth must turn as the gyroscope does. Needs samples.
void report_truth(const Recording& recording, CheckReport& report);

}  // namespace chasles
