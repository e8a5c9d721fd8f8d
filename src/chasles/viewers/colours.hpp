#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <chasles/camera/pixel_outcome.hpp>

namespace chasles {

// The page's colours, except for a grey that is visible on dark and light backgrounds.
inline constexpr unsigned kEstimateColour = 0x0068bd;
inline constexpr unsigned kTruthColour = 0x8a8f98;
inline constexpr unsigned kDeadReckoningColour = 0xcf4f00;
inline constexpr unsigned kClosureColour = 0xb3127a;

/// The colour of a point in an image, as on the page; visible on dark and bright backgrounds.
unsigned outcome_colour(Outcome outcome);

/// The colour of a session of a saved map, as on the page: eight colours, in turn.
unsigned session_colour(int session);

using Rgb = std::array<std::uint8_t, 3>;

/// Red, green, blue of 0xRRGGBB.
Rgb rgb(unsigned colour);

/// Colours of sigmas, from dark violet (small) over teal to yellow (large): even steps of the
/// logarithm between the 5 % and the 95 % quantile of the positive, finite sigmas.
class SigmaColours {
 public:
  explicit SigmaColours(std::vector<double> sigmas);
  Rgb operator()(double sigma) const;

 private:
  double low_ = 0, high_ = 0;  ///< logarithms
};

}  // namespace chasles
