#pragma once

#include <chasles/base/settings.hpp>

namespace chasles {

/// Form of a landmark in the state: a point of the world, or a ray and an inverse depth in the
/// camera of its first observation.
enum class LandmarkForm { kCartesian, kInverseDepth };

template <>
struct Choices<LandmarkForm> {
  static constexpr std::array list{Choice{LandmarkForm::kCartesian, "cartesian"},
                                   Choice{LandmarkForm::kInverseDepth, "inverse-depth"}};
};

}  // namespace chasles
