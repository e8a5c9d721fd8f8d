#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include <chasles/pipeline/estimator.hpp>
#include <chasles/run_folder/run.hpp>

// What a run recognised, as summary.json and the command's output have it.
namespace chasles::app {

/// The entries `closures`, `recognised_ns`, `recognised_tracks` and, with a prior map or after a
/// loss, `place_in_map`.
nlohmann::ordered_json recognition_json(const EstimatorReport& report, const Run& run,
                                        bool has_prior_map);

/// Lines of text for those entries of a summary that are there.
std::string recognition_text(const nlohmann::ordered_json& summary);

}  // namespace chasles::app
