#pragma once

#include <array>

#include <chasles/base/settings.hpp>

namespace chasles {

/// By what past landmarks are recognised.
enum class Recognise { kNone, kIds, kAppearance };

/// What the filter does with the map of an earlier run.
enum class PriorMapUse { kEstimated, kConsidered };

template <>
struct Choices<Recognise> {
  static constexpr std::array list{Choice{Recognise::kNone, "none"}, Choice{Recognise::kIds, "ids"},
                                   Choice{Recognise::kAppearance, "appearance"}};
};

template <>
struct Choices<PriorMapUse> {
  static constexpr std::array list{Choice{PriorMapUse::kEstimated, "estimated"},
                                   Choice{PriorMapUse::kConsidered, "considered"}};
};

}  // namespace chasles
