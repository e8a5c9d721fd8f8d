#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>

#include <chasles/run_folder/run.hpp>

namespace chasles {

/// The rows of states.csv from index `from` on, in parts (write_parts()); with the names of the
/// columns if `from` is 0. The run must stay as it is until the last one.
std::function<bool(std::string& part)> state_parts(const Run& run, std::size_t from = 0);

/// landmarks.csv, in parts. The landmarks must stay until the last one.
std::function<bool(std::string& part)> landmark_parts(std::span<const RunLandmark> landmarks);

}  // namespace chasles
