#pragma once

#include <filesystem>

#include <chasles/report/report.hpp>

namespace chasles {

/// Reads a run folder for its page; the summary includes timing.json if the file exists. Throws
/// InputError.
ReportRun read_with_timing(const std::filesystem::path& folder);

}  // namespace chasles
