#pragma once

#include <string>

#include <chasles/sim/inertial_settings.hpp>

namespace chasles {

/// Puts what the path of a scene and its real samples agree on in the place of the path: turned
/// upright (fit_gravity) and fused with the samples (fuse_poses), which are weighted by the
/// settings' noise. So images and samples are of one motion, as those of a camera and an IMU on one
/// body. Returns what was moved by how much, a sentence for the user to read. Throws InputError
/// where poses and samples tell no gravity, or where fuse_poses does.
std::string make_agree(InertialScene& scene);

}  // namespace chasles
