#pragma once

#include <string>

#include <chasles/sim/inertial_settings.hpp>

namespace chasles {

/// Replaces the path of a scene by one that is consistent with its real IMU samples. The path is
/// rotated upright (fit_gravity) and fused with the samples (fuse_poses), which are weighted by the
/// settings' noise. Images and samples then have one motion, as for a camera and an IMU on one
/// body. Returns a sentence for the user on the size of the change. Throws InputError if poses and
/// samples do not determine gravity, or as fuse_poses() does.
std::string make_agree(InertialScene& scene);

}  // namespace chasles
