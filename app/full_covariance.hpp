#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <chasles/data/run.hpp>
#include <chasles/filter/ekf.hpp>

namespace chasles::app {

/// Throws UsageError unless the file's folder is there and the file can be opened for writing.
void check_full_covariance(const std::filesystem::path& file);

/// Writes the covariance of all errors of the map and the core: a one-dimensional .npy of N(N+1)/2
/// float64, the lower triangle row by row, and beside it FILE with the extension .csv, which says
/// what each of the N rows is; `landmarks` are those of filter.map(), in its order. The
/// matrix is never in memory as a whole. Throws UsageError where the disk has no room for it or
/// writing fails; then no part of it is left behind.
void write_full_covariance(const Ekf& filter, const std::vector<std::string>& additive_names,
                           const std::vector<RunLandmark>& landmarks,
                           const std::filesystem::path& file);

}  // namespace chasles::app
