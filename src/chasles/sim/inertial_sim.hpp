#pragma once

#include <cstdint>

#include <chasles/numeric/spline.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/sim/inertial_settings.hpp>

namespace chasles {

/// Simulates an IMU and cameras that move among landmarks (Kleinert & Stilla, V-A;
/// docs/simulation.md). The result has the type that a reader returns, with the truth. `truth` and
/// `true_motion` have one entry per frame, world_T_imu with z up; `true_landmarks` has every
/// landmark ever observed.
///
/// The motion, the landmarks and the times of their observations depend on the settings alone;
/// biases and all noise on the settings and the run. The same scene and run give the same bytes. A
/// scene with real IMU samples returns those samples and only the frames that they cover; its
/// `true_motion` is empty, because the biases are unknown. Throws UsageError if the scene cannot be
/// simulated.
Recording simulate_inertial(const InertialScene& scene, std::uint64_t run = 0);

/// Simulates cameras, IMU and truth, without frames, landmarks and pixel_sigma. `motion`: that of
/// the scene.
Recording simulate_sensors(const InertialScene& scene, const Spline& motion, std::uint64_t run);

/// The true motion of a scene.
Spline inertial_motion(const InertialScene& scene);

}  // namespace chasles
