#pragma once

#include <string>
#include <string_view>

#include <chasles/viewers/run_path.hpp>

namespace chasles {

/// The poses world_T_imu with their covariances in SQUARE 0.3, the text format of smfeval
/// (docs/formats.md): of X = Xhat Exp(xi) the covariance of xi = [translation; rotation], IMU axes,
/// [m, rad], lower triangle row by row. The gauge is fixed: the run defines its world. Poses whose
/// covariance is singular or not finite are left out, among them the first. `version` is that of
/// the program. Throws InputError for a run without poses of that path.
std::string run_square(const Run& run, RunPath path, std::string_view version);

/// The truth at the times of these poses in the run's world as TUM's lines, for a comparison
/// without any alignment: nees() aligns the worlds in the same way. The truth must have attitudes.
/// Throws InputError for a run without a truth or without poses of that path, and where estimate
/// and truth cannot be compared.
std::string square_truth(const Run& run, RunPath path);

}  // namespace chasles
