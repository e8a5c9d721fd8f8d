#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/smooth/batch/batch.hpp>
#include <chasles/smooth/window/window.hpp>

namespace chasles::app {

/// summary.json's "batch": how the minimum was found. Nothing in it differs from run to run.
nlohmann::ordered_json batch_json(const BatchReport& report);

/// The same of a window: summary.json's "window".
nlohmann::ordered_json window_json(const WindowReport& report);

/// What timing.json says of them.
void append_timing(const BatchReport& report, nlohmann::ordered_json& timing);
void append_timing(const WindowReport& report, nlohmann::ordered_json& timing);

/// What there is to say about it in words.
void append_remarks(const BatchReport& report, std::vector<std::string>& remarks);

}  // namespace chasles::app
