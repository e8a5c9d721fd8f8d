#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include <chasles/check/check_report.hpp>
#include <chasles/frontend/frontend_settings.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles {

/// Length of the images that are tracked, by default [s].
inline constexpr double kCheckedSeconds = 20;

/// All that `chasles check` examines. Of images: `seconds` of them, those with the most rotation,
/// tracked with these settings. Throws as read_masks().
CheckReport diagnose(const Recording& recording, double seconds = kCheckedSeconds,
                     const FrontendSettings& frontend = {});

/// The same without its truth, and without a trial of the filter: for whoever runs the recording.
CheckReport examine(const Recording& recording, double seconds = kCheckedSeconds,
                    const FrontendSettings& frontend = {});

/// The report as `chasles check` prints it, as text and with --json.
std::string check_text(const Recording& recording, const CheckReport& report);
nlohmann::ordered_json check_json(const Recording& recording, const CheckReport& report);

/// What a check finds of a recording that a run did not estimate, as the end of a sentence: "see
/// `chasles check`", with the worst finding that names a cause. Examines the recording.
std::string finding_of_check(const Recording& recording, const FrontendSettings& frontend = {});

}  // namespace chasles
