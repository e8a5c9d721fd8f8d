#pragma once

#include <Eigen/Core>

#include <chasles/filter/covariance.hpp>
#include <chasles/filter/past/past.hpp>
#include <chasles/filter/state.hpp>

namespace chasles {

/// A landmark of the state as one of the map, in world axes. The position of an anchored landmark
/// also depends on its anchor.
MapLandmark as_of_now(const State& x, const Covariance& covariance, const Landmark& landmark);

/// The derivative of its position in the axes of the map (nav axes where nav_T_world is a state,
/// else world axes) by all `size` errors of the state.
Eigen::Matrix<double, 3, Eigen::Dynamic> derivative_in_map_axes(const State& x,
                                                                const Landmark& landmark,
                                                                Eigen::Index size);

/// The same landmark in the axes of the map, with the errors of these.
MapLandmark in_map_axes(const State& x, const Covariance& covariance, const Landmark& landmark);

}  // namespace chasles
