#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <chasles/run_folder/run.hpp>

namespace chasles {

/// The rows of states.csv from index `from` on; with the names of the columns if `from` is 0.
std::string states_text(const Run& run, std::size_t from);

/// landmarks.csv.
std::string landmarks_text(const std::vector<RunLandmark>& landmarks);

}  // namespace chasles
