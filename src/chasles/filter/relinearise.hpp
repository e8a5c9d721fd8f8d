#pragma once

#include <Eigen/Core>

#include <chasles/filter/charts/error_chart.hpp>
#include <chasles/filter/measurement.hpp>

namespace chasles {

/// The errors (reference chart) by which an update of x leads to y, which has the same rows.
Eigen::VectorXd correction_between(const ErrorChart& chart, const State& x, const State& y);

/// From a measurement that is linearised at y to the same as a function of the errors at x, with
/// `correction` = correction_between(chart, x, y). An update of x with it is a Gauss-Newton step
/// (iterated Kalman filter: Bell & Cathey, IEEE T-AC 1993). As an update does with the covariance,
/// the derivatives change by T(y)^-1 T(x) (error_chart.hpp).
void refer_to(const ErrorChart& chart, const State& x, const State& y,
              const Eigen::VectorXd& correction, Measurement& z);

}  // namespace chasles
