#pragma once

#include <optional>

#include <chasles/filter/whitening.hpp>

namespace chasles {

/// Whether the measurements depend only on clones (and imu_T_camera) and have more rows than those
/// have errors. Then fewer rows contain the same information.
bool can_be_compressed(Measurements measurements, WhiteningScratch& scratch);

/// The result of whiten() for such measurements, with fewer columns of W. It uses the pivoted
/// Cholesky decomposition of their information,
///
///   H^T R^-1 H = L L^T,   L z = H^T R^-1 r   (L is c x rank, c the errors they depend on),
///
/// z = L^T d + n with noise of unit covariance contains all their information on the errors d. The
/// part of r outside the range of H contributes to the NIS only. The MSCKF does the same by QR
/// (Mourikis & Roumeliotis 2007), which takes twice the time. None if a noise or S is not positive
/// definite or a number is not finite.
std::optional<Whitened> whiten_compressed(Measurements measurements, const Covariance& covariance,
                                          const dense::ConstBlock& Z, WhiteningScratch& scratch);

}  // namespace chasles
