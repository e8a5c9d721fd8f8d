#pragma once

#include <string>
#include <string_view>

namespace chasles {

/// Checks the arrays of a MATLAB file of version 5 before libmatio sees them, which allocates
/// memory for any size that a header claims, and calls itself for each cell within a cell. `bytes`
/// are the whole file. Throws InputError if it ends within an array, an array's header is none, a
/// cell or struct claims more members than its bytes can hold, or members nest too deep or take too
/// much memory (read_budget.hpp).
void check_mat_structure(std::string_view bytes, bool big_endian, const std::string& file);

}  // namespace chasles
