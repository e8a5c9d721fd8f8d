#pragma once

#include <cstddef>
#include <string>

namespace chasles {

/// What a reader may spend on one file. A few bytes can claim gigabytes or nest arrays without end;
/// the limits are far above those of real recordings (docs/formats.md).
struct ReadBudget {
  std::size_t bytes = std::size_t{512} << 20;  ///< memory for the content of a file
  int depth = 100;                             ///< arrays, maps or cells inside each other
};

/// The budget of this process: the defaults, or CHASLES_READ_MEMORY (bytes, or with the unit K, M
/// or G of 1024, as "2G") and CHASLES_READ_DEPTH. Read from the environment at each call. Throws
/// UsageError for a value that is none.
ReadBudget read_budget();

/// Throws InputError if `bytes` exceed the budget. `what` is what needs them: "FILE: has 3000000000
/// bytes".
void check_memory(const std::string& what, std::size_t bytes);

/// Throws InputError if `depth` exceeds the budget. `where` names the file.
void check_depth(const std::string& where, int depth);

}  // namespace chasles
