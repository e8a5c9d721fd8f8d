#pragma once

#include <chasles/filter/charts/error_chart.hpp>
#include <chasles/imu/strapdown.hpp>

namespace chasles {

/// Replaces F, Q and d_gravity of a step, which starts at `state`, by those to first order in its
/// length, as Kleinert & Stilla propagate their covariance: Phi = I + F tau (14) and Phi G Q G^T
/// Phi^T tau (15), with F and G of the error's differential equation in the chart: `standard`
/// (23)-(27), `left-se3` (39)-(41) with (40) corrected, `right-se3` (47)-(49). `interval` has the
/// values as measured, `gravity_world` is in world axes [m/s^2]. The result is in the reference
/// chart. docs/derivations.md, section 10, has the corrections. Throws UsageError for the
/// chart right-sen3, which is not the paper's.
void linearise_to_first_order(const ErrorChart& chart, const InertialState& state,
                              const ImuInterval& interval, const Eigen::Vector3d& gravity_world,
                              const ImuNoise& noise, StrapdownStep& step);

}  // namespace chasles
