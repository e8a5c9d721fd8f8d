#pragma once

#include <string>

#include <chasles/check/check_report.hpp>
#include <chasles/data/recording.hpp>

namespace chasles::app {

/// Length of the images that are tracked, by default [s].
inline constexpr double kCheckedSeconds = 20;

/// All that `chasles check` examines. Of images: `seconds` of them, those with the most rotation.
CheckReport diagnose(const Recording& recording, double seconds = kCheckedSeconds);

/// What a check finds of a recording that a run did not estimate, as the end of a sentence: "see
/// `chasles check`", with the worst finding that names a cause. Examines the recording.
std::string finding_of_check(const Recording& recording);

}  // namespace chasles::app
