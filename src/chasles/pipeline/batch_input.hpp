#pragma once

#include <chasles/slam/inertial_session.hpp>
#include <chasles/smooth/batch/batch.hpp>

namespace chasles {

/// The input of batch estimation and windows: sensors, noise and chart of the filter's settings,
/// the parts of the calibration that these estimate or consider, and the start. Samples, frames and
/// initial states are empty.
InertialBatchInput batch_input(const InertialSensors& sensors, const InertialSlamSettings& settings,
                               const InertialStart& start);

/// A filter's estimate as a start; it does not depend on any landmark yet. `of_filter`: the start
/// at which the filter began, with its dependence on the IMU's parameters (InertialStart::by_imu).
InertialStart start_at(const Estimate& e, const std::optional<InertialStart>& of_filter);

/// The uncertainty of position and heading at a start after a gap. Pixels and samples do not depend
/// on it, and where it is large the normal equations are ill-conditioned. So the part is estimated
/// with an exact place, to whose results the uncertainty is added.
struct Place {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  ///< [rotation about z, position]
};

/// Removes it from the covariance of the input's start.
Place take_place(InertialBatchInput& input);
void add_place(const Place& place, Estimate& estimate);
void add_place(const Place& place, MapLandmark& landmark);

/// Lets the search begin at this calibration, which replaces that of `cameras`, as stated. The
/// start is that of an image, at the estimate `first`, and moves with it by the change of the time
/// offset.
void begin_at(const Calibration& calibration, const std::vector<Camera>& cameras,
              const Estimate& first, InertialBatchInput& input);

/// A filter's estimate as an initial state of batch estimation with that time offset: a filter that
/// estimates the offset has its estimates at other times.
TimedMotion timed_motion(const Estimate& e, Time time_offset);

}  // namespace chasles
