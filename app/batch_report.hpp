#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/smooth/batch.hpp>

namespace chasles::app {

/// Whether the search converged at a minimum that fits the data.
bool believable(const BatchReport& report);

/// summary.json's "batch": how the minimum was found. Nothing in it differs from run to run.
nlohmann::ordered_json batch_json(const BatchReport& report);

/// What timing.json says of it.
void append_timing(const BatchReport& report, nlohmann::ordered_json& timing);

/// What there is to say about it in words.
void append_remarks(const BatchReport& report, std::vector<std::string>& remarks);

}  // namespace chasles::app
