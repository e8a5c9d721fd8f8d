#pragma once

#include <map>
#include <vector>

#include <Eigen/Core>

#include <chasles/target/saddle_points.hpp>
#include <chasles/target/target.hpp>

namespace chasles {

/// Saddle points by their place in the grid of corners (tag_layout.hpp): columns and rows.
using FoundCorners = std::map<std::pair<int, int>, SaddlePoint>;

/// Removes corners that are not where their neighbours have them, by a homography through those: by
/// more than half of the distance to the nearest neighbour. A board of tags and squares between
/// them looks the same one tag farther, so this is no proof of their ids.
void remove_misplaced(const Target& target, FoundCorners& corners);

/// Adds saddle points that are where the neighbours of a missing corner have it, with edges to two
/// of the next corners at least. `image` is smoothed.
void add_missing(const Target& target, const GreyPlane& image,
                 const std::vector<SaddlePoint>& points, FoundCorners& corners);

/// How far around each corner there is nothing but its own edges [px], by the distances to the next
/// corners in the image; infinite for a corner without any.
std::map<std::pair<int, int>, double> free_radii(const Target& target, const FoundCorners& corners);

/// The distance to the nearest of the next corners in the image, for each corner that has one [px].
std::vector<double> spacings(const FoundCorners& corners);

}  // namespace chasles
