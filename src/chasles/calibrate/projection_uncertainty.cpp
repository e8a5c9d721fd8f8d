#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <chasles/calibrate/projection_uncertainty.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;

struct GridPoint {
  Vector2d pixel;
  PixelBearing direction;
};

std::vector<GridPoint> grid_of(const Camera& camera, int columns, int rows) {
  std::vector<GridPoint> grid;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const Vector2d pixel((camera.width - 1.0) * i / (columns - 1.0),
                           (camera.height - 1.0) * j / (rows - 1.0));
      if (const auto direction = bearing(camera, pixel)) grid.push_back({pixel, *direction});
    }
  }
  return grid;
}

}  // namespace

std::vector<PixelUncertainty> projection_uncertainty(const Camera& camera,
                                                     const MatrixXd& covariance, int columns,
                                                     int rows) {
  const std::vector<GridPoint> grid = grid_of(camera, columns, rows);
  const auto count = 2 * static_cast<Eigen::Index>(grid.size());
  MatrixXd by_turn(count, 3), by_parameters(count, covariance.rows());
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const Vector3d& b = grid[i].direction.bearing;
    const auto row = 2 * static_cast<Eigen::Index>(i);
    by_turn.block<2, 3>(row, 0) = -project(camera, b)->d_point * hat(b);
    by_parameters.middleRows<2>(row) = *parameter_derivative(camera, b);
  }
  const Eigen::Matrix3d square = by_turn.transpose() * by_turn;
  const MatrixXd turn = square.ldlt().solve(by_turn.transpose() * by_parameters);
  const MatrixXd left = by_parameters - by_turn * turn;
  std::vector<PixelUncertainty> result;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const MatrixXd J = left.middleRows<2>(2 * static_cast<Eigen::Index>(i));
    const Matrix2d P = J * covariance * J.transpose();
    const Eigen::Matrix<double, 3, 2>& by_pixel = grid[i].direction.d_pixel;
    const Matrix2d angles = by_pixel.transpose() * by_pixel * P;  // its trace: of both angles
    result.push_back(
        {.pixel = grid[i].pixel,
         .sigma_px = std::sqrt(Eigen::SelfAdjointEigenSolver<Matrix2d>(P).eigenvalues()[1]),
         .sigma_rad = std::sqrt(angles.eigenvalues().real().maxCoeff())});
  }
  return result;
}

std::vector<PixelDifference> projection_difference(const Camera& camera, const Camera& other,
                                                   int columns, int rows) {
  const std::vector<GridPoint> grid = grid_of(camera, columns, rows);
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  std::vector<PixelDifference> result;
  constexpr int kSteps = 6;
  for (int step = 0; step <= kSteps; ++step) {
    result.clear();
    Eigen::Matrix3d H = 1e-12 * Eigen::Matrix3d::Identity();
    Vector3d g = Vector3d::Zero();
    for (const GridPoint& point : grid) {
      const Vector3d turned = R * point.direction.bearing;
      const auto image = project(other, turned);
      if (!image) continue;
      const Eigen::Matrix<double, 2, 3> J = -image->d_point * hat(turned);
      result.push_back({point.pixel, image->pixel - point.pixel});
      H += J.transpose() * J;
      g += J.transpose() * result.back().difference;
    }
    if (step < kSteps) R = so3::exp(-H.ldlt().solve(g)) * R;
  }
  return result;
}

MatrixXd lens_covariance(const CamerasCalibration& calibration, std::size_t camera) {
  const CamerasLayout layout = calibration.layout();
  const int row = layout.lens_row(camera), n = layout.lens(camera).parameters();
  return calibration.covariance.block(row, row, n, n);
}

double rms_of(const std::vector<PixelDifference>& differences) {
  double sum = 0;
  for (const PixelDifference& one : differences) sum += one.difference.squaredNorm() / 2;
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, differences.size())));
}

double rms_of(const std::vector<PixelUncertainty>& grid) {
  double sum = 0;
  for (const PixelUncertainty& one : grid) sum += one.sigma_px * one.sigma_px;
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, grid.size())));
}

}  // namespace chasles
