#pragma once

#include <string>

#include <chasles/data/run.hpp>

namespace chasles {

/// Map and trajectories as a binary little-endian PLY (docs/formats.md). Vertices are the
/// landmarks, then the positions of the estimate, of the truth (aligned by the first pose, as on
/// the page) and of dead reckoning; `kind` distinguishes them (0 to 3). Each has float x, y, z [m],
/// uchar red, green, blue, float sigma (root of the covariance's trace [m]) and cov_xx … cov_zz
/// [m^2], int landmark (-1: none) and int observations; truth and dead reckoning have zeros.
/// Landmarks are coloured by sigma, each trajectory has one colour. Edges join the positions of a
/// trajectory. Values that are not finite are left out.
std::string run_ply(const Run& run);

}  // namespace chasles
