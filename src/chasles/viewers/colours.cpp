#include <algorithm>
#include <cmath>

#include <chasles/viewers/colours.hpp>

namespace chasles {
namespace {

// Lightness rises evenly, so that the order is visible with any kind of colour vision.
constexpr std::array<std::array<double, 3>, 6> kRamp = {
    {{62, 22, 98}, {54, 78, 140}, {30, 128, 142}, {48, 172, 116}, {142, 208, 66}, {252, 226, 60}}};

}  // namespace

unsigned outcome_colour(Outcome outcome) {
  switch (outcome) {
    case Outcome::kUsed:
      return 0x4fc6ff;
    case Outcome::kRejected:
      return 0xff7b3d;
    case Outcome::kInitialised:
      return 0xffe24a;
    default:
      return 0xf4f4f4;
  }
}

unsigned session_colour(int session) {
  constexpr std::array<unsigned, 8> kHues = {0x0d8a68, 0xc2410c, 0x6b4fc4, 0x7a5c00,
                                             0xa3123f, 0x2a93b8, 0x5b6470, 0x0068bd};
  return kHues[static_cast<std::size_t>(session) % kHues.size()];
}

Rgb rgb(unsigned colour) {
  return {static_cast<std::uint8_t>(colour >> 16), static_cast<std::uint8_t>(colour >> 8),
          static_cast<std::uint8_t>(colour)};
}

SigmaColours::SigmaColours(std::vector<double> sigmas) {
  std::erase_if(sigmas, [](double s) { return !(std::isfinite(s) && s > 0); });
  if (sigmas.empty()) return;
  std::ranges::sort(sigmas);
  const std::size_t last = sigmas.size() - 1;
  low_ = std::log(sigmas[last / 20]);
  high_ = std::log(sigmas[last - last / 20]);
}

Rgb SigmaColours::operator()(double sigma) const {
  const double place = high_ > low_ ? (std::log(sigma) - low_) / (high_ - low_) : 0;
  const double x = std::clamp(std::isnan(place) ? 1 : place, 0.0, 1.0) * (kRamp.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(x), kRamp.size() - 2);
  Rgb colour{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double mixed =
        kRamp[i][k] + (x - static_cast<double>(i)) * (kRamp[i + 1][k] - kRamp[i][k]);
    colour[k] = static_cast<std::uint8_t>(std::lround(mixed));
  }
  return colour;
}

}  // namespace chasles
