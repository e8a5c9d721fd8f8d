#pragma once

#include <optional>

#include <chasles/filter/whitening.hpp>

namespace chasles {

/// Whether the measurements depend on nothing but clones (and imu_T_camera) and have more rows
/// than those have errors: then fewer rows tell the same.
bool can_be_compressed(Measurements measurements, WhiteningScratch& scratch);

/// What whiten() gives for such measurements, but for W's number of columns. By Cholesky's
/// decomposition with pivots of their information,
///
///   H^T R^-1 H = L L^T,   L z = H^T R^-1 r   (L is c x rank, c the errors they depend on),
///
/// z = L^T d + n with noise of unit covariance tells of the errors d all that they tell; the part
/// of r outside of H's range adds to the NIS alone. The MSCKF does the same by QR (Mourikis &
/// Roumeliotis 2007), in twice the time. None where a noise or S is not positive definite
/// or a number is not finite.
std::optional<Whitened> whiten_compressed(Measurements measurements, const Covariance& covariance,
                                          WhiteningScratch& scratch);

}  // namespace chasles
