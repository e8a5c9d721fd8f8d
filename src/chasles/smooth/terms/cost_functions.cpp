#include <chasles/filter/pixel_projection.hpp>
#include <chasles/smooth/terms/cost_functions_detail.hpp>

namespace chasles::smooth_detail {
namespace {

template <int Rows, int Columns>
using RowMajorMap = Eigen::Map<Eigen::Matrix<double, Rows, Columns, Eigen::RowMajor>>;

// Writes the derivative by a keyframe's fifteen errors to its two blocks.
void write(const Matrix15d& d, double* by_motion, double* by_biases) {
  if (by_motion != nullptr) {
    RowMajorMap<15, kMotionNumbers> J(by_motion);
    J.setZero();
    J.leftCols<kMotionErrors>() = d.leftCols<kMotionErrors>();
  }
  if (by_biases != nullptr) RowMajorMap<15, 6>{by_biases} = d.rightCols<6>();
}

}  // namespace

bool StartCost::Evaluate(const double* const* x, double* residuals, double** jacobians) const {
  Matrix15d J;
  Eigen::Map<Vector15d>{residuals} =
      start_residual(*graph_, read_state(x[0], x[1]), jacobians != nullptr ? &J : nullptr);
  if (jacobians != nullptr) write(J, jacobians[0], jacobians[1]);
  return true;
}

bool LinkCost::Evaluate(const double* const* x, double* residuals, double** jacobians) const {
  LinkDerivatives d;
  Eigen::Map<Vector15d>{residuals} =
      link_residual(*link_, read_state(x[0], x[1]), read_state(x[2], x[3]), gravity_,
                    jacobians != nullptr ? &d : nullptr);
  if (jacobians != nullptr) {
    write(d.now, jacobians[0], jacobians[1]);
    write(d.next, jacobians[2], jacobians[3]);
  }
  return true;
}

std::optional<PredictedView<2>> PixelTerm::see(const SE3& world_T_imu,
                                               const HomogeneousPoint& point) const {
  const auto seen = chasles::see(*camera, cam_T_imu, world_T_imu, point, pixel, least_depth);
  if (!seen) return std::nullopt;
  return PredictedView<2>{.residual = -seen->residual / sigma,
                          .d_w = seen->d_w / sigma,
                          .d_point = seen->d_point / sigma,
                          .d_pose = seen->d_pose / sigma};
}

bool InverseDepthCost::Evaluate(const double* const* x, double* residuals,
                                double** jacobians) const {
  residuals[0] = x[0][2] / sigma_;
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    RowMajorMap<1, 3>{jacobians[0]} << 0, 0, 1 / sigma_;
  }
  return true;
}

}  // namespace chasles::smooth_detail
