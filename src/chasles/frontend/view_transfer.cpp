#include <chasles/frontend/view_transfer.hpp>

namespace chasles {

std::optional<Transfer> transfer(const WideRay& from, double inverse_depth, const SE3& to_T_from,
                                 const Camera& to) {
  // A pixel does not change along the ray: uses a distant point, which is not below the minimum
  // depth.
  constexpr double kFar = 1000;
  const Eigen::Vector3d p_to = kFar * (to_T_from.R * from.ray + inverse_depth * to_T_from.p);
  const std::optional<PixelProjection> seen = project(to, p_to);
  if (!seen) return std::nullopt;
  const Eigen::Matrix<double, 2, 3> d_ray = kFar * seen->d_point;
  return Transfer{.pixel = seen->pixel,
                  .to_A_from = d_ray * to_T_from.R * from.d_pixel,
                  .d_inverse_depth = d_ray * to_T_from.p};
}

Eigen::Matrix<double, 2, 3> transfer_bow(const Camera& from, const Camera& to,
                                         const Eigen::Matrix3d& to_R_from,
                                         const Eigen::Vector2d& pixel, double reach) {
  constexpr double kFar = 1000;
  Eigen::Matrix<double, 2, 9> seen;  // of the offsets (-1, -1), (0, -1) ... (1, 1)
  for (int i = 0; i < 9; ++i) {
    const Eigen::Vector2d offset(i % 3 - 1, i / 3 - 1);
    const std::optional<PixelBearing> direction = bearing(to, pixel + reach * offset);
    if (!direction) return Eigen::Matrix<double, 2, 3>::Zero();
    const auto back = project(from, kFar * (to_R_from.transpose() * direction->bearing));
    if (!back) return Eigen::Matrix<double, 2, 3>::Zero();
    seen.col(i) = back->pixel;
  }
  Eigen::Matrix<double, 2, 3> bow;
  bow << (seen.col(3) + seen.col(5)) / 2 - seen.col(4),
      (seen.col(0) + seen.col(8) - seen.col(2) - seen.col(6)) / 4,
      (seen.col(1) + seen.col(7)) / 2 - seen.col(4);
  return bow / (reach * reach);
}

}  // namespace chasles
