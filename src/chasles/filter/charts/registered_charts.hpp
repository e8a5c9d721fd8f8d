#pragma once

#include <functional>
#include <string>

#include <chasles/filter/charts/error_chart.hpp>

namespace chasles {

/// An error chart of a program's own, as ErrorChart describes one. The functions may throw; what
/// they throw ends the run.
struct CustomChart {
  std::string name;
  std::string summary;
  std::function<void(State& x, const ErrorRef& xi)> retract;
  std::function<Eigen::VectorXd(const State& x, const State& y)> local;
  std::function<Eigen::Matrix<double, 9, 9>(const State& x)> motion_block;
  std::function<Eigen::Matrix3d(const Eigen::Vector3d& p_world)> landmark_block = nullptr;
};

/// Makes the chart known by its name to error_chart(), and so to the setting `chart`, in this
/// process. It replaces an earlier one of the same name for filters that are made from now on.
/// Throws UsageError for the name of a chart of the library, for one that is empty or has other
/// characters than letters, digits, '-' and '_', and as check_error_chart().
const ErrorChart& register_error_chart(CustomChart chart);

/// Checks the invariants of ErrorChart at fixed random states, with and without velocity, biases,
/// clones and landmarks. Throws UsageError with the first one that does not hold, and by how much.
void check_error_chart(const ErrorChart& chart);

}  // namespace chasles
