#pragma once

#include <span>
#include <string_view>

#include <Eigen/Core>

#include <chasles/filter/charts/chart_function.hpp>
#include <chasles/filter/charts/error_chart_names.hpp>
#include <chasles/filter/state.hpp>

namespace chasles {

/// An error vector, or a segment of one.
using ErrorRef = Eigen::Ref<const Eigen::VectorXd>;

/// An error chart defines how an error xi acts on the mean (retract) and which error leads from one
/// mean to another (local). The filter is implemented once, in the reference chart (`standard`).
/// Another chart enters only through T(x), the derivative of its coordinates by the reference ones
/// (docs/derivations.md, D14; docs/charts.md):
///
///   after an update   x+ = retract(x, T(x) delta),   P <- T(x+)^-1 T(x) P T(x)^T T(x+)^-T
///
/// T is block lower-triangular: a block on the rows of pose and v_world, one on each clone's rows,
/// and one block in each landmark's rows under the rotation's columns.
///
/// Invariants (asserted for every chart of error_charts() in error_chart_test.cpp):
///   1. retract(x, 0) = x
///   2. local(x, retract(x, xi)) = xi
///   3. pull(push(M)) = M
///   4. push(x, I) = numeric derivative of local(x, ·) after the standard retraction
///   5. where landmark_block is set, the rotation's rows of motion_block are the identity's
struct ErrorChart {
  std::string_view name;
  std::string_view summary;  ///< one line for --help

  /// x (+) xi for pose, v_world, additive states and landmarks. xi has an entry for every row of
  /// the state. The function retract covers the whole state.
  ChartFunction<void(State& x, const ErrorRef& xi)> retract;
  /// The xi with retract(x, xi) = y for the same parts. Both have the same landmarks in the same
  /// rows.
  ChartFunction<Eigen::VectorXd(const State& x, const State& y)> local;
  /// T's block for [rotation, position, v_world]: 9x9; only its top left 6x6 is used without
  /// v_world.
  ChartFunction<Eigen::Matrix<double, 9, 9>(const State& x)> motion_block;
  /// T's block for (Cartesian landmark, rotation); null where landmarks are additive.
  ChartFunction<Eigen::Matrix3d(const Eigen::Vector3d& p_world)> landmark_block;
};

/// The charts of the library, for the command line and the tests.
std::span<const ErrorChart> error_charts();

/// The chart with this name, also a registered one. Throws UsageError for an unknown name; the
/// message lists the names.
const ErrorChart& error_chart(std::string_view name);

/// x (+) xi and its inverse for the whole state. The pose of a clone has the chart's pose error.
/// The errors of nav_T_world, of the calibration and of anchored landmarks are the same in all
/// charts.
void retract(const ErrorChart& chart, State& x, const ErrorRef& xi);
Eigen::VectorXd local(const ErrorChart& chart, const State& x, const State& y);

/// T's block for a single pose, as for a clone.
Matrix6d pose_block(const ErrorChart& chart, const SE3& world_T_imu);

/// M <- T(x) M and M <- T(x)^-1 M, for a matrix with a row for every error of the state.
void push(const ErrorChart& chart, const State& x, Eigen::Ref<Eigen::MatrixXd> M);
void pull(const ErrorChart& chart, const State& x, Eigen::Ref<Eigen::MatrixXd> M);

/// A transition F of the reference chart from x to next, in the coordinates of the chart: T(next) F
/// T(x)^-1.
Eigen::MatrixXd in_chart(const ErrorChart& chart, const Eigen::MatrixXd& F, const State& x,
                         const State& next);

// The charts themselves, one .cpp each.
extern const ErrorChart kStandardChart;   ///< Kleinert & Stilla (17)
extern const ErrorChart kLeftSe3Chart;    ///< Kleinert & Stilla (30)
extern const ErrorChart kRightSe3Chart;   ///< Kleinert & Stilla (45)
extern const ErrorChart kRightSen3Chart;  ///< SE_{2+N}(3), landmarks in the group

}  // namespace chasles
