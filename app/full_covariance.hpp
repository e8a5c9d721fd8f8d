#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <chasles/filter/ekf.hpp>
#include <chasles/run_folder/run.hpp>

namespace chasles::app {

/// Throws UsageError if the file's folder does not exist or the file cannot be opened for writing.
void check_full_covariance(const std::filesystem::path& file);

/// Writes the joint N x N covariance of the whole map and the other states. `file` is a
/// one-dimensional .npy of N(N+1)/2 float64, the lower triangle row by row. A second file with the
/// extension .csv names each of the N rows. `landmarks` are those of filter.map(), in its order.
/// The whole matrix is never in memory. Throws UsageError if the disk has too little space or
/// writing fails; incomplete files are then removed.
void write_full_covariance(const Ekf& filter, const std::vector<std::string>& additive_names,
                           const std::vector<RunLandmark>& landmarks,
                           const std::filesystem::path& file);

}  // namespace chasles::app
