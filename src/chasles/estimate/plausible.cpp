#include <algorithm>
#include <cmath>

#include <chasles/estimate/plausible.hpp>

namespace chasles {
namespace {

constexpr int kFewCompared = 6;
constexpr double kInconsistent = 1.5;
constexpr int kManyObservations = 20, kFewUsed = 4;
// A speed with this sigma [m/s], and this part of itself, is unknown. New landmarks then have
// depths as wrong, and do not correct it; an initialisation finds it in a second.
constexpr double kUnknownSpeed = 1, kUnknownPart = 0.5;

bool is_finite(const Calibration& c) {
  return c.covariance.allFinite() && std::isfinite(c.time_offset.value_or(0)) &&
         std::ranges::all_of(c.imu_T_camera,
                             [](const SE3& imu_T_camera) {
                               return imu_T_camera.R.allFinite() && imu_T_camera.p.allFinite();
                             }) &&
         std::ranges::all_of(c.intrinsics, [](const Intrinsics& one) {
           return one.projection.allFinite() && std::isfinite(one.readout) &&
                  one.coefficients.is_finite();
         });
}

}  // namespace

bool is_finite(const Estimate& e) {
  if (e.calibration && !is_finite(*e.calibration)) return false;
  if (e.in_map && !(e.in_map->map_T_imu.p.allFinite() && e.in_map->covariance.allFinite())) {
    return false;
  }
  return e.world_T_imu.R.allFinite() && e.world_T_imu.p.allFinite() && e.v_world->allFinite() &&
         e.additive.allFinite() && e.covariance.allFinite() && std::isfinite(e.nis) &&
         std::isfinite(e.innovation_products) && std::isfinite(e.innovation_squares);
}

bool is_finite(const PastPose& pose) {
  return pose.map_T_imu.R.allFinite() && pose.map_T_imu.p.allFinite() &&
         pose.covariance.allFinite();
}

bool has_unknown_speed(const Estimate& e) {
  const double variance = e.covariance.diagonal().segment<3>(6).maxCoeff();
  const double limit = std::max(kUnknownSpeed, kUnknownPart * e.v_world->norm());
  return e.observations >= kManyObservations && variance > limit * limit;
}

bool contradicted(const Estimate& e) {
  const int used = e.used + e.tracks.used, rejected = e.rejected + e.tracks.rejected;
  const int compared = rejected + used;
  const bool inconsistent = e.nis > kInconsistent * e.nis_dof;
  const bool mostly_rejected =
      compared >= kFewCompared && (inconsistent ? 5 : 3) * rejected > compared;
  const bool starves =
      !e.zero_velocity && e.observations >= kManyObservations && used + e.tracks.waiting < kFewUsed;
  return mostly_rejected || starves || has_unknown_speed(e);
}

}  // namespace chasles
