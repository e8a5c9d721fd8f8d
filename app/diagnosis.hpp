#pragma once

#include <string>

#include <chasles/check/check_report.hpp>
#include <chasles/data/recording.hpp>
#include <chasles/frontend/frontend_settings.hpp>

namespace chasles::app {

/// Length of the images that are tracked, by default [s].
inline constexpr double kCheckedSeconds = 20;

/// All that `chasles check` examines. Of images: `seconds` of them, those with the most rotation,
/// tracked with these settings. Throws as read_masks().
CheckReport diagnose(const Recording& recording, double seconds = kCheckedSeconds,
                     const FrontendSettings& frontend = {});

/// What a check finds of a recording that a run did not estimate, as the end of a sentence: "see
/// `chasles check`", with the worst finding that names a cause. Examines the recording.
std::string finding_of_check(const Recording& recording, const FrontendSettings& frontend = {});

}  // namespace chasles::app
