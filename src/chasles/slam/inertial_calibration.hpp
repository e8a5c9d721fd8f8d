#pragma once

#include <deque>
#include <span>
#include <vector>

#include <chasles/filter/calibration.hpp>
#include <chasles/initialise/inertial_start.hpp>
#include <chasles/slam/inertial_settings.hpp>

namespace chasles {

/// The part of the calibration that the settings estimate, before any measurement: the extrinsics
/// and intrinsics of `cameras`, the time offset of the settings, and an IMU without errors, with
/// the initial sigmas of the settings. None where nothing is estimated or considered.
std::optional<Calibration> stated_calibration(const InertialSlamSettings& settings,
                                              std::span<const Camera> cameras);

/// The initial sigmas of a camera's intrinsics, in the order of Intrinsics; 1 in its empty rows.
std::vector<double> intrinsics_sigmas(const InertialSlamSettings& settings, const Camera& camera);

/// The initial sigmas of ImuCorrection::parameters.
Eigen::VectorXd imu_sigmas(const InertialSlamSettings& settings, const ImuCorrection& imu);

/// The rows of the core that the settings consider (Ekf::Options::considered).
std::vector<int> considered_rows(const InertialSlamSettings& settings, const State& x);

/// The cameras with the estimated extrinsics and intrinsics.
std::vector<Camera> calibrated(std::vector<Camera> cameras,
                               const std::optional<Calibration>& calibration);

/// Enlarges the covariance of an initialisation for the errors of its calibration, by the sigmas of
/// time offset and rotations, and of the IMU (widen_start_by_imu). Without motion, nothing is added
/// for cameras and clock.
/// Images that come `s` seconds late appear rotated and shifted by s times the angular rate and the
/// acceleration, against the samples of the same stamp. The variation of the rates within the
/// window causes errors of tilt, velocity and, divided by the window's length, biases. A wrong
/// camera rotation rotates the velocity. `samples`: those of the initialisation, in order of time.
void widen_start(const Calibration& calibration, const std::deque<ImuSample>& samples,
                 InertialStart& start);

}  // namespace chasles
