#pragma once

#include <chasles/camera/camera.hpp>
#include <chasles/filter/charts/error_chart.hpp>
#include <chasles/filter/measurement.hpp>

namespace chasles {

/// Replaces the derivatives of a pixel's measurement (measure_pixel) by numeric ones, as Kleinert &
/// Stilla find them (IV-C): central differences of the projection over errors of 1e-5 [rad, m] of
/// pose and landmark in the chart, then brought to the reference chart. Only for a Cartesian
/// landmark and known extrinsics (asserted). The analytic ones stay where a perturbed point has no
/// projection.
void differentiate_numerically(const ErrorChart& chart, const Camera& camera, const State& x,
                               Measurement& measurement);

}  // namespace chasles
