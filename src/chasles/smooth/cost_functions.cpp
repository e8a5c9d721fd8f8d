#include <chasles/filter/pixel_sight.hpp>
#include <chasles/smooth/cost_functions_detail.hpp>

namespace chasles::smooth_detail {
namespace {

template <int Rows, int Columns>
using RowMajorMap = Eigen::Map<Eigen::Matrix<double, Rows, Columns, Eigen::RowMajor>>;
using Matrix23d = Eigen::Matrix<double, 2, 3>;

InertialState state_of(const double* motion, const double* biases) {
  InertialState state;
  read_motion(motion, state);
  state.accelerometer_bias = Eigen::Map<const Eigen::Vector3d>(biases);
  state.gyroscope_bias = Eigen::Map<const Eigen::Vector3d>(biases + 3);
  return state;
}

SE3 pose_of(const double* motion) {
  return {.R = Eigen::Map<const Eigen::Matrix3d>(motion),
          .p = Eigen::Map<const Eigen::Vector3d>(motion + 9)};
}

// The derivative by a keyframe's fifteen errors into its two blocks.
void write(const Matrix15d& d, double* by_motion, double* by_biases) {
  if (by_motion != nullptr) {
    RowMajorMap<15, kMotionNumbers> J(by_motion);
    J.setZero();
    J.leftCols<kMotionErrors>() = d.leftCols<kMotionErrors>();
  }
  if (by_biases != nullptr) RowMajorMap<15, 6>{by_biases} = d.rightCols<6>();
}

void write_pose(const Eigen::Matrix<double, 2, 6>& d, double* by_motion) {
  if (by_motion == nullptr) return;
  RowMajorMap<2, kMotionNumbers> J(by_motion);
  J.setZero();
  J.leftCols<6>() = d;
}

void write_not_seen(double* residuals, double** jacobians, std::initializer_list<int> sizes) {
  residuals[0] = residuals[1] = kNotSeen;
  if (jacobians == nullptr) return;
  int block = 0;
  for (const int size : sizes) {
    if (jacobians[block] != nullptr) std::fill_n(jacobians[block], 2 * size, 0.0);
    ++block;
  }
}

void write_residual(const Seen& seen, double sigma, double* residuals) {
  residuals[0] = -seen.residual.x() / sigma;
  residuals[1] = -seen.residual.y() / sigma;
}

Landmark landmark_of(const Camera& anchor_camera, const double* parameters) {
  Landmark landmark;
  landmark.anchor = 0;
  landmark.cam_T_imu = anchor_camera.cam_T_imu;
  landmark.inverse_depth = Eigen::Map<const Eigen::Vector3d>(parameters);
  return landmark;
}

// By the anchor's pose and the parameters.
Eigen::Matrix<double, 2, 9> by_anchored(const Seen& seen, const Clone& anchor,
                                        const Landmark& landmark) {
  Eigen::Matrix<double, 2, 9> d = seen.d_point * homogeneous_derivative(anchor, landmark);
  d.rightCols<1>() += seen.d_w;
  return d;
}

}  // namespace

bool StartCost::Evaluate(const double* const* x, double* residuals, double** jacobians) const {
  Matrix15d J;
  Eigen::Map<Vector15d>{residuals} =
      start_residual(*graph_, state_of(x[0], x[1]), jacobians != nullptr ? &J : nullptr);
  if (jacobians != nullptr) write(J, jacobians[0], jacobians[1]);
  return true;
}

bool LinkCost::Evaluate(const double* const* x, double* residuals, double** jacobians) const {
  LinkDerivatives d;
  Eigen::Map<Vector15d>{residuals} =
      link_residual(*link_, state_of(x[0], x[1]), state_of(x[2], x[3]), gravity_,
                    jacobians != nullptr ? &d : nullptr);
  if (jacobians != nullptr) {
    write(d.now, jacobians[0], jacobians[1]);
    write(d.next, jacobians[2], jacobians[3]);
  }
  return true;
}

bool PointCost::Evaluate(const double* const* x, double* residuals, double** jacobians) const {
  const HomogeneousPoint point{.p_world = Eigen::Map<const Eigen::Vector3d>(x[1]), .w = 1};
  const auto seen = see(*term_.camera, pose_of(x[0]), point, term_.pixel);
  if (!seen) {
    write_not_seen(residuals, jacobians, {kMotionNumbers, 3});
    return true;
  }
  write_residual(*seen, term_.sigma, residuals);
  if (jacobians == nullptr) return true;
  write_pose(seen->d_pose / term_.sigma, jacobians[0]);
  if (jacobians[1] != nullptr) RowMajorMap<2, 3>{jacobians[1]} = seen->d_point / term_.sigma;
  return true;
}

bool AnchoredCost::Evaluate(const double* const* x, double* residuals, double** jacobians) const {
  const Clone anchor{.world_T_imu = pose_of(x[1])};
  const Landmark landmark = landmark_of(*term_.anchor_camera, x[2]);
  const auto seen = see(*term_.camera, pose_of(x[0]), homogeneous(anchor, landmark), term_.pixel);
  if (!seen) {
    write_not_seen(residuals, jacobians, {kMotionNumbers, kMotionNumbers, 3});
    return true;
  }
  write_residual(*seen, term_.sigma, residuals);
  if (jacobians == nullptr) return true;
  const Eigen::Matrix<double, 2, 9> d = by_anchored(*seen, anchor, landmark) / term_.sigma;
  write_pose(seen->d_pose / term_.sigma, jacobians[0]);
  write_pose(d.leftCols<6>(), jacobians[1]);
  if (jacobians[2] != nullptr) RowMajorMap<2, 3>{jacobians[2]} = d.rightCols<3>();
  return true;
}

bool AnchorCost::Evaluate(const double* const* x, double* residuals, double** jacobians) const {
  const Clone anchor;
  const Landmark landmark = landmark_of(*term_.anchor_camera, x[0]);
  const auto seen =
      see(*term_.camera, anchor.world_T_imu, homogeneous(anchor, landmark), term_.pixel);
  if (!seen) {
    write_not_seen(residuals, jacobians, {3});
    return true;
  }
  write_residual(*seen, term_.sigma, residuals);
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    RowMajorMap<2, 3>{jacobians[0]} =
        by_anchored(*seen, anchor, landmark).rightCols<3>() / term_.sigma;
  }
  return true;
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
