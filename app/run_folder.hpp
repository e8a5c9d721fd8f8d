#pragma once

#include <filesystem>

#include <chasles/report/report.hpp>

namespace chasles::app {

/// A run folder for its page: the summary with timing.json, where there is one. Throws InputError.
ReportRun read_with_timing(const std::filesystem::path& folder);

}  // namespace chasles::app
