#pragma once

#include <string>

#include <chasles/run_folder/run.hpp>

namespace chasles {

/// Whether a PLY has the element `edge`, which some readers reject (meshio 5).
enum class PlyEdges { kNo, kYes };

/// Map and trajectories as a binary little-endian PLY (docs/formats.md). Vertices are the
/// landmarks (those of a prior map have a kind of their own), then the positions of the estimate,
/// of the truth (aligned by the first pose, as on the page) and of dead reckoning; `kind`
/// distinguishes them (0, 4, 1 to 3). Each has float x, y, z [m], uchar red, green, blue, float
/// sigma (root of the covariance's trace [m]) and cov_xx … cov_zz [m^2], int landmark (-1: none),
/// int observations, int session of the prior map (-1: none) and uchar returned, 1 for a landmark
/// of the prior map that the run has recognised; truth and dead reckoning have zeros. Landmarks are
/// coloured by sigma, those of kind 4 by session, each trajectory has one colour. Edges join the
/// positions of a trajectory. Values that are not finite are left out.
std::string run_ply(const Run& run, PlyEdges edges = PlyEdges::kYes);

/// The landmarks of a saved map in its frame, as vertices of kind 4, without edges.
std::string map_ply(const MapSketch& map);

}  // namespace chasles
