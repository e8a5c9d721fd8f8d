#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>

#include <chasles/run_folder/run.hpp>

namespace chasles {

/// The rows of states.csv from index `from` on; with the names of the columns if `from` is 0.
std::string states_text(const Run& run, std::size_t from);

/// landmarks.csv, in parts (write_parts()). The landmarks must stay until the last one.
std::function<bool(std::string& part)> landmark_parts(std::span<const RunLandmark> landmarks);

}  // namespace chasles
