#pragma once

#include <chasles/settings.hpp>

namespace chasles {

/// What a landmark is in the state: a point of the world, or a ray and an inverse depth in the
/// camera that saw it first.
enum class LandmarkForm { kCartesian, kInverseDepth };

template <>
struct Choices<LandmarkForm> {
  static constexpr std::array list{Choice{LandmarkForm::kCartesian, "cartesian"},
                                   Choice{LandmarkForm::kInverseDepth, "inverse-depth"}};
};

}  // namespace chasles
