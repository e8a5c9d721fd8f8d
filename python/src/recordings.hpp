#pragma once

#include <span>

#include <chasles/recording/recording.hpp>

#include "arrays.hpp"

namespace chasles::python {

/// The recording with images that several threads of Python may read: a run reads ahead while
/// another thread looks at them.
Recording shared(Recording recording);

/// {"time": (N,) int64 [ns], "specific_force": (N, 3) [m/s^2], "angular_rate": (N, 3) [rad/s]}.
py::dict imu_columns(std::span<const ImuSample> imu);

}  // namespace chasles::python
