#pragma once

#include <chasles/initialise/inertial_start.hpp>
#include <chasles/slam/inertial_settings.hpp>

namespace chasles {

/// The start's own covariance, or the initial sigmas of the settings: roll and pitch are errors
/// about nav's horizontal axes.
Matrix15d start_covariance(const InertialSlamSettings& settings, const InertialStart& start);

}  // namespace chasles
