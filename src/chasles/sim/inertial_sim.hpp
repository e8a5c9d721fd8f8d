#pragma once

#include <cstdint>

#include <chasles/data/recording.hpp>
#include <chasles/numeric/spline.hpp>
#include <chasles/sim/inertial_settings.hpp>

namespace chasles {

/// Simulates an IMU and cameras that move among landmarks (Kleinert & Stilla, V-A;
/// docs/simulation.md): the very type that a reader gives, with the truth. `truth` and
/// `true_motion` have one entry a frame, world_T_imu with z up; `true_landmarks` has every landmark
/// ever observed.
///
/// The motion, the landmarks and which of them are observed when depend on the settings alone;
/// biases and all noise on the settings and the run. The same scene and run give the same bytes. A
/// scene with real IMU samples hands those on, has only the frames that they cover, and its
/// `true_motion` is empty, for their biases are not known. UsageError where the scene cannot be
/// simulated.
Recording simulate_inertial(const InertialScene& scene, std::uint64_t run = 0);

/// All of it but what is seen: cameras, IMU and truth, without frames, landmarks and pixel_sigma.
/// `motion`: the scene's.
Recording simulate_sensors(const InertialScene& scene, const Spline& motion, std::uint64_t run);

/// The true motion of a scene.
Spline inertial_motion(const InertialScene& scene);

}  // namespace chasles
