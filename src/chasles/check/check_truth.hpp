#pragma once

#include <string_view>

#include <chasles/check/check_report.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles {

/// How the finding on a truth begins whose world leans, or whose poses are not the IMU's.
inline constexpr std::string_view kLeanBegins = "gravity leans ";

/// Compares the truth with the IMU: gravity must point down in the truth's world (fit_gravity). How
/// far its turns are from the gyroscope's is a fact; examine_truth() of eval/ finds the causes.
/// Needs samples, and a truth whose attitude changes.
void report_truth(const Recording& recording, CheckReport& report);

}  // namespace chasles
