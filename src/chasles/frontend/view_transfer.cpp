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

}  // namespace chasles
