#pragma once

#include <string>

#include <chasles/data/run.hpp>

namespace chasles {

/// Map and ways as a binary little-endian PLY (docs/formats.md). Vertices: the landmarks, then the
/// positions of the estimate, of the truth (placed by the first pose, as the page does) and of dead
/// reckoning; `kind` tells which (0 to 3). Each has float x, y, z [m], uchar red, green, blue,
/// float sigma (root of the covariance's trace [m]) and cov_xx … cov_zz [m^2], int landmark (-1:
/// none) and int observations; truth and dead reckoning have zeros. Colours are those of sigma
/// among the landmarks, and one a way. Edges join the positions of a way. What is not finite is
/// left out.
std::string run_ply(const Run& run);

}  // namespace chasles
