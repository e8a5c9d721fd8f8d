#include <algorithm>

#include <chasles/filter/pixel_projection.hpp>
#include <chasles/smooth/terms/velocity_costs_detail.hpp>

// The costs of a landmark's views, for every kind of term.
namespace chasles::smooth_detail {
namespace {

template <int Rows, int Columns>
using RowMajorMap = Eigen::Map<Eigen::Matrix<double, Rows, Columns, Eigen::RowMajor>>;

template <typename Term>
using Derivative = Eigen::Matrix<double, Term::kRows, 6>;

template <typename Term>
void write_pose(const Derivative<Term>& d, double* by_motion) {
  if (by_motion == nullptr) return;
  RowMajorMap<Term::kRows, Term::kNumbers> J(by_motion);
  J.setZero();
  J.template leftCols<6>() = d;
}

template <typename Term>
void write_not_seen(double* residuals, double** jacobians, std::initializer_list<int> sizes) {
  std::fill_n(residuals, Term::kRows, kNotSeen);
  if (jacobians == nullptr) return;
  int block = 0;
  for (const int size : sizes) {
    if (jacobians[block] != nullptr) std::fill_n(jacobians[block], Term::kRows * size, 0.0);
    ++block;
  }
}

template <typename Term>
void write_residual(const PredictedView<Term::kRows>& seen, double* residuals) {
  Eigen::Map<Eigen::Matrix<double, Term::kRows, 1>>{residuals} = seen.residual;
}

Landmark landmark_of(const SE3& cam_T_imu, const double* parameters) {
  Landmark landmark;
  landmark.anchor = 0;
  landmark.cam_T_imu = cam_T_imu;
  landmark.inverse_depth = Eigen::Map<const Eigen::Vector3d>(parameters);
  return landmark;
}

// By the anchor's pose and the parameters.
template <int Rows>
Eigen::Matrix<double, Rows, 9> by_anchored(const PredictedView<Rows>& seen, const Clone& anchor,
                                           const Landmark& landmark) {
  Eigen::Matrix<double, Rows, 9> d = seen.d_point * homogeneous_derivative(anchor, landmark);
  d.template rightCols<1>() += seen.d_w;
  return d;
}

}  // namespace

template <typename Term>
bool PointCost<Term>::Evaluate(const double* const* x, double* residuals,
                               double** jacobians) const {
  const HomogeneousPoint point{.p_world = Eigen::Map<const Eigen::Vector3d>(x[1]), .w = 1};
  const auto seen = term_.see(read_pose(x[0]), point);
  if (!seen) {
    write_not_seen<Term>(residuals, jacobians, {Term::kNumbers, 3});
    return true;
  }
  write_residual<Term>(*seen, residuals);
  if (jacobians == nullptr) return true;
  write_pose<Term>(seen->d_pose, jacobians[0]);
  if (jacobians[1] != nullptr) RowMajorMap<Term::kRows, 3>{jacobians[1]} = seen->d_point;
  return true;
}

template <typename Term>
bool AnchoredCost<Term>::Evaluate(const double* const* x, double* residuals,
                                  double** jacobians) const {
  const Clone anchor{.world_T_imu = read_pose(x[1])};
  const Landmark landmark = landmark_of(term_.anchor_cam_T_imu(), x[2]);
  const auto seen = term_.see(read_pose(x[0]), homogeneous(anchor, landmark));
  if (!seen) {
    write_not_seen<Term>(residuals, jacobians, {Term::kNumbers, Term::kNumbers, 3});
    return true;
  }
  write_residual<Term>(*seen, residuals);
  if (jacobians == nullptr) return true;
  const Eigen::Matrix<double, Term::kRows, 9> d = by_anchored(*seen, anchor, landmark);
  write_pose<Term>(seen->d_pose, jacobians[0]);
  write_pose<Term>(d.template leftCols<6>(), jacobians[1]);
  if (jacobians[2] != nullptr) {
    RowMajorMap<Term::kRows, 3>{jacobians[2]} = d.template rightCols<3>();
  }
  return true;
}

template <typename Term>
bool AnchorCost<Term>::Evaluate(const double* const* x, double* residuals,
                                double** jacobians) const {
  const Clone anchor;
  const Landmark landmark = landmark_of(term_.anchor_cam_T_imu(), x[0]);
  const auto seen = term_.see(anchor.world_T_imu, homogeneous(anchor, landmark));
  if (!seen) {
    write_not_seen<Term>(residuals, jacobians, {3});
    return true;
  }
  write_residual<Term>(*seen, residuals);
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    RowMajorMap<Term::kRows, 3>{jacobians[0]} =
        by_anchored(*seen, anchor, landmark).template rightCols<3>();
  }
  return true;
}

template class PointCost<PixelTerm>;
template class AnchoredCost<PixelTerm>;
template class AnchorCost<PixelTerm>;
template class PointCost<StereoTerm<2>>;
template class AnchoredCost<StereoTerm<2>>;
template class AnchorCost<StereoTerm<2>>;
template class PointCost<StereoTerm<3>>;
template class AnchoredCost<StereoTerm<3>>;
template class AnchorCost<StereoTerm<3>>;
template class PointCost<StereoTerm<4>>;
template class AnchoredCost<StereoTerm<4>>;
template class AnchorCost<StereoTerm<4>>;

}  // namespace chasles::smooth_detail
