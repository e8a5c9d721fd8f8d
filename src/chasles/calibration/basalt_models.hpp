#pragma once

#include <array>
#include <string_view>
#include <vector>

#include <chasles/camera/lenses/lens_model.hpp>

namespace chasles {

/// A model of Basalt, and the keys of its coefficients in the order of ours. `ucm` is eucm with
/// beta = 1.
struct BasaltModel {
  std::string_view name;
  Distortion model;
  std::vector<const char*> keys;
};

/// The models of Basalt's files that this library has.
const std::vector<BasaltModel>& basalt_models();

/// Row and column of the numbers of calib_accel_bias after its bias: lower triangular, by columns.
inline constexpr std::array<std::array<int, 2>, 6> kBasaltForcePlaces{
    {{0, 0}, {1, 0}, {2, 0}, {1, 1}, {2, 1}, {2, 2}}};

}  // namespace chasles
