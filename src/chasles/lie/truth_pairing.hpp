#pragma once

#include <array>
#include <optional>

#include <chasles/base/settings.hpp>
#include <chasles/lie/trajectory.hpp>

namespace chasles {

/// How an estimate finds its truth.
enum class Pairing {
  kInterpolate,  ///< the truth at each of its stamps, as pose_at()
  kNearest,      ///< the poses that are nearest in time to each other
};

template <>
struct Choices<Pairing> {
  static constexpr std::array list{Choice{Pairing::kInterpolate, "interpolate"},
                                   Choice{Pairing::kNearest, "nearest"}};
};

struct TruthPairing {
  Pairing pairing = Pairing::kInterpolate;
  Time longest_gap = kLongestTruthGap;  ///< with kInterpolate
  /// With kNearest, the largest accepted difference of stamps; none: half the smaller of the two
  /// median spacings.
  std::optional<Time> tolerance{};
};

}  // namespace chasles
