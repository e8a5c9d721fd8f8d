#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <chasles/target/local_homography.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

// Moves the points to their mean, and scales them to a distance of about one.
Matrix3d normalisation(const std::vector<BoardPixel>& points, Vector2d BoardPixel::*member) {
  Vector2d mean = Vector2d::Zero();
  for (const BoardPixel& p : points) mean += p.*member / static_cast<double>(points.size());
  double squares = 0;
  for (const BoardPixel& p : points) squares += (p.*member - mean).squaredNorm();
  const double scale = std::sqrt(static_cast<double>(points.size()) / squares);
  Matrix3d N = Matrix3d::Identity();
  N(0, 0) = N(1, 1) = scale;
  N.topRightCorner<2, 1>() = -scale * mean;
  return N;
}

}  // namespace

std::optional<Matrix3d> local_homography(const std::vector<BoardPixel>& points) {
  if (points.size() < 4) return std::nullopt;
  const Matrix3d board = normalisation(points, &BoardPixel::on_board);
  const Matrix3d image = normalisation(points, &BoardPixel::pixel);
  if (!board.allFinite() || !image.allFinite()) return std::nullopt;
  Eigen::Matrix<double, 8, 8> normal = Eigen::Matrix<double, 8, 8>::Zero();
  Eigen::Matrix<double, 8, 1> right = Eigen::Matrix<double, 8, 1>::Zero();
  for (const BoardPixel& p : points) {
    const Vector2d x = (board * p.on_board.homogeneous()).head<2>();
    const Vector2d u = (image * p.pixel.homogeneous()).head<2>();
    for (int k = 0; k < 2; ++k) {
      Eigen::Matrix<double, 8, 1> row = Eigen::Matrix<double, 8, 1>::Zero();
      row.segment<3>(3 * k) = x.homogeneous();
      row.tail<2>() = -u(k) * x;
      normal += row * row.transpose();
      right += row * u(k);
    }
  }
  const Eigen::LDLT<Eigen::Matrix<double, 8, 8>> ldlt(normal);
  if (!(ldlt.vectorD().minCoeff() > 1e-6)) return std::nullopt;
  const Eigen::Matrix<double, 8, 1> h = ldlt.solve(right);
  Matrix3d H;
  H << h(0), h(1), h(2), h(3), h(4), h(5), h(6), h(7), 1;
  return Matrix3d(image.inverse() * H * board);
}

}  // namespace chasles
