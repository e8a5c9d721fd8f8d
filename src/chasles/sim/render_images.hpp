#pragma once

#include <cstdint>
#include <memory>

#include <chasles/numeric/spline.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/sim/inertial_settings.hpp>
#include <chasles/sim/render_world.hpp>

namespace chasles {

/// As `simulate_inertial`, with `images` instead of landmarks and their observations. IMU, truth
/// and the frames' times are the same. Images are rendered on request: the view of the cameras in
/// the rooms of `make_render_world`, at the pose of the frame's time or, with an exposure_time, as
/// the mean of `blur_samples` instants about it; with a rolling shutter, each line at its own time.
/// The same scene, run and frame give the same bytes, in any order of reading, and from several
/// threads at a time.
///
/// With real samples whose biases are known (`imu_truth`), `true_motion` has those biases and the
/// velocity of the motion. Throws UsageError if the scene cannot be simulated.
Recording render_inertial(const InertialScene& scene, std::uint64_t run = 0);

/// The images of a rig's cameras in a world along a motion, at the given times.
std::shared_ptr<const ImageSource> make_image_source(const InertialSettings& settings,
                                                     std::uint64_t run, PaintedWorld world,
                                                     const std::vector<Camera>& cameras,
                                                     const Spline& motion,
                                                     const std::vector<Time>& times);

}  // namespace chasles
