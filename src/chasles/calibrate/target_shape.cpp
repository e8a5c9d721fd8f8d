#include <Eigen/Geometry>

#include <chasles/calibrate/target_shape.hpp>

namespace chasles {

TargetShape bent_shape(const std::vector<Eigen::Vector3d>& corners) {
  constexpr double kBendSigma = 0.005;
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector3d& corner : corners) box.extend(Eigen::Vector2d(corner.head<2>()));
  TargetShape shape{
      .names = {"bend_x", "bend_y"}, .by_parameters = {}, .sigma = kBendSigma * box.sizes()};
  for (const Eigen::Vector3d& corner : corners) {
    const Eigen::Vector2d x = (corner.head<2>() - box.center()).cwiseQuotient(box.sizes() / 2);
    Eigen::Matrix<double, 3, Eigen::Dynamic> d(3, 2);
    d << Eigen::Matrix2d::Zero(), (Eigen::Vector2d::Ones() - x.cwiseProduct(x)).transpose();
    shape.by_parameters.push_back(std::move(d));
  }
  return shape;
}

TargetShape printed_shape(const Target& target) {
  constexpr double kGrowthSigma = 0.01;
  TargetShape shape = bent_shape(target.corners());
  if (target.kind != TargetKind::april_grid) return shape;
  shape.names.push_back("growth");
  shape.sigma.conservativeResize(3);
  shape.sigma[2] = kGrowthSigma * target.tag_size;
  for (std::size_t i = 0; i < shape.by_parameters.size(); ++i) {
    // Corners of a tag: from the lower left, counterclockwise.
    const std::size_t k = i % 4;
    shape.by_parameters[i].conservativeResize(3, 3);
    shape.by_parameters[i].col(2) << (k == 1 || k == 2 ? 1 : -1), (k >= 2 ? 1 : -1), 0;
  }
  return shape;
}

}  // namespace chasles
