#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <chasles/check/check_rotation.hpp>
#include <chasles/lie/small_matrices.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

constexpr std::size_t kFewestPairs = 8;
constexpr int kIterations = 12;
constexpr double kLeastScale = 3e-4;  // of an angle: a sixth of a pixel [rad]
constexpr double kConverged = 1e-7;   // [rad]

using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

// The residual at which the Cauchy cost changes from square to logarithm: a robust sigma.
double scale_of(std::vector<double> sizes) {
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return std::max(kLeastScale, 1.5 * *middle);
}

double cauchy_weight(double error, double scale) {
  return 1 / (1 + error * error / (scale * scale));
}

// The rotation that best maps the first rays to the second ones, without translation.
Eigen::Matrix3d rotation_alone(const std::vector<TwoRays>& pairs) {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  std::vector<double> sizes(pairs.size());
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      sizes[i] = (pairs[i].second - R * pairs[i].first).norm();
    }
    const double scale = scale_of(sizes);
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const Eigen::Vector3d turned = R * pairs[i].first;
      const Eigen::Matrix3d J = -hat(turned);
      const double weight = cauchy_weight(sizes[i], scale);
      A += weight * J.transpose() * J;
      b += weight * J.transpose() * (pairs[i].second - turned);
    }
    const Eigen::Vector3d step = solve_symmetric(A, b);
    R = so3::exp(step) * R;
    if (step.norm() < kConverged) break;
  }
  return R;
}

// The direction nearest to all epipolar planes.
Eigen::Vector3d first_direction(const std::vector<TwoRays>& pairs, const Eigen::Matrix3d& R) {
  Eigen::Matrix3d M = Eigen::Matrix3d::Zero();
  for (const TwoRays& pair : pairs) {
    const Eigen::Vector3d n = (R * pair.first).cross(pair.second);
    M += n * n.transpose() / (n.squaredNorm() + kLeastScale * kLeastScale);
  }
  return symmetric_eigen(M).vectors.col(0);
}

// Two directions perpendicular to t.
Eigen::Matrix<double, 3, 2> across(const Eigen::Vector3d& t) {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
  if (std::abs(t.x()) > 0.7) axis = Eigen::Vector3d::UnitY();
  Eigen::Matrix<double, 3, 2> B;
  B.col(0) = t.cross(axis).normalized();
  B.col(1) = t.cross(B.col(0));
  return B;
}

// The angle between a ray and its epipolar plane, and its derivative by [rotation; direction].
struct Residual {
  double angle = 0;
  Vector5d J = Vector5d::Zero();
};

Residual residual_of(const TwoRays& pair, const Eigen::Matrix3d& R, const Eigen::Vector3d& t,
                     const Eigen::Matrix<double, 3, 2>& B) {
  const Eigen::Vector3d a = R * pair.first;
  const Eigen::Vector3d n = a.cross(pair.second);
  const double sine = std::max(t.cross(a).norm(), 1e-2);
  Residual residual{.angle = t.dot(n) / sine};
  residual.J.head<3>() = a.cross(pair.second.cross(t)) / sine;
  residual.J.tail<2>() = B.transpose() * n / sine;
  return residual;
}

// The normal equations over rotation and direction.
struct Equations {
  Matrix5d A = Matrix5d::Zero();
  Vector5d b = Vector5d::Zero();
};

Equations equations_of(const std::vector<Residual>& residuals, double scale) {
  Equations equations;
  for (const Residual& r : residuals) {
    const double weight = cauchy_weight(r.angle, scale);
    equations.A += weight * r.J * r.J.transpose();
    equations.b -= weight * r.angle * r.J;
  }
  // Without a translation its direction is undetermined: the prior costs one scale per radian.
  equations.A.diagonal().tail<2>().array() += scale * scale;
  equations.A.diagonal().head<3>().array() += 1e-9;
  return equations;
}

// The information of the rotation, with the direction of the translation marginalised.
Eigen::Matrix3d information_of(const Matrix5d& A, double scale, std::size_t pairs) {
  const Eigen::Matrix<double, 3, 2> mixed = A.topRightCorner<3, 2>();
  const Eigen::Matrix2d direction = A.bottomRightCorner<2, 2>();
  const Eigen::Matrix3d schur =
      A.topLeftCorner<3, 3>() - mixed * direction.inverse() * mixed.transpose();
  // The same residuals fitted five parameters and determine the scale, 1.5 medians.
  const double left = static_cast<double>(pairs - 5) / static_cast<double>(pairs);
  return schur * left / (scale * scale);
}

}  // namespace

std::optional<RelativeRotation> relative_rotation(const std::vector<TwoRays>& pairs,
                                                  const std::optional<Eigen::Matrix3d>& start) {
  if (pairs.size() < kFewestPairs) return std::nullopt;
  RelativeRotation result{.second_R_first = start ? *start : rotation_alone(pairs)};
  Eigen::Matrix3d& R = result.second_R_first;
  Eigen::Vector3d t = first_direction(pairs, R);
  std::vector<Residual> residuals(pairs.size());
  std::vector<double> sizes(pairs.size());
  for (int iteration = 0; iteration < 3 * kIterations; ++iteration) {
    const auto B = across(t);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      residuals[i] = residual_of(pairs[i], R, t, B);
      sizes[i] = std::abs(residuals[i].angle);
    }
    const double scale = scale_of(sizes);
    const Equations equations = equations_of(residuals, scale);
    const Vector5d step = solve_symmetric(equations.A, equations.b);
    if (!step.allFinite() || step.head<3>().norm() > 0.5) return std::nullopt;
    result.information = information_of(equations.A, scale, pairs.size());
    R = so3::exp(step.head<3>()) * R;
    t = (t + B * step.tail<2>()).normalized();
    if (step.head<3>().norm() < kConverged) break;
  }
  return result;
}

}  // namespace chasles
