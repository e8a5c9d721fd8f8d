#pragma once

#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/report/against_truth.hpp>
#include <chasles/report/report.hpp>

namespace chasles {

/// What src/web/src/page.ts reads: {bounds, scenes (scenes.hpp), runs: [{name, label, summary,
/// level, origin, states, landmarks, map (map_data.hpp), …, images (page_images.hpp)}]}. `level`:
/// the z axis of the run's world is vertical (is_level()). Numbers are columns (encode.hpp).
/// Positions are relative to the run's origin, so that single precision is accurate to a millimetre
/// some kilometres away. Angles are in degrees, times in seconds from the first state.
nlohmann::ordered_json page_data(const std::vector<ReportRun>& runs);

/// `bounds` of page_data: the 95 % intervals of chi-square.
nlohmann::ordered_json page_bounds();

/// An entry of `runs` with this summary; `errors` is against_truth() of the run.
nlohmann::ordered_json run_data(const ReportRun& run, nlohmann::ordered_json summary,
                                const AgainstTruth& errors);

}  // namespace chasles
