#pragma once

#include <cstdint>
#include <vector>

namespace chasles {

/// The grey (ITU-R BT.601) of a Bayer mosaic, row by row. `red`: the place of the red pixel within
/// each 2 x 2 pixels, 2 * row + column. Red, green and blue of a pixel are the means of the nearest
/// pixels of the colour; beyond an edge the mosaic continues mirrored. Integers only.
std::vector<std::uint16_t> grey_of_mosaic(const std::vector<std::uint16_t>& mosaic, int width,
                                          int height, int red);

}  // namespace chasles
