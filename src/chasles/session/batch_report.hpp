#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/smooth/batch/batch.hpp>
#include <chasles/smooth/window/window.hpp>

namespace chasles {

/// The object "batch" of summary.json: how the minimum was found. Identical runs give identical
/// values.
nlohmann::ordered_json batch_json(const BatchReport& report);

/// The object "window" of summary.json.
nlohmann::ordered_json window_json(const WindowReport& report);

/// Adds their times to timing.json.
void append_timing(const BatchReport& report, nlohmann::ordered_json& timing);
void append_timing(const WindowReport& report, nlohmann::ordered_json& timing);

/// Adds a remark for each problem of the solution, and for covariances that were widened.
void append_remarks(const BatchReport& report, std::vector<std::string>& remarks);
void append_remarks(const WindowReport& report, std::vector<std::string>& remarks);

}  // namespace chasles
