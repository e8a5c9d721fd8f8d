#pragma once

#include <array>
#include <cstdint>

// The codes of OpenCV's dictionaries: the bits of a marker row by row from its upper left corner,
// the first one highest; 1 is white. The dictionaries _50, _100 and _250 are the first codes of
// those of 1000. They are numbers that printed boards have: those of ArUco by its authors, those of
// AprilTags by Olson's search, in OpenCV under the licence Apache-2.0.
namespace chasles::marker_codes {

extern const std::array<std::uint64_t, 1000> k4X4_1000, k5X5_1000, k6X6_1000, k7X7_1000;
extern const std::array<std::uint64_t, 30> kAPRILTAG_16h5;
extern const std::array<std::uint64_t, 35> kAPRILTAG_25h9;
extern const std::array<std::uint64_t, 587> kAPRILTAG_36h11;
extern const std::array<std::uint64_t, 250> kARUCO_MIP_36h12;
extern const std::array<std::uint64_t, 1024> kARUCO_ORIGINAL;

}  // namespace chasles::marker_codes
