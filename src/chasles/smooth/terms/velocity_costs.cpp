#include <algorithm>

#include <chasles/smooth/terms/velocity_costs_detail.hpp>

namespace chasles::smooth_detail {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double kLeastW = 0.01;  // for points without a depth limit: those far to the side

// The additive states of the keyframe whose motion is block `first`.
VelocityState state_of(const double* const* x, int first, int additive) {
  VelocityState state{.world_T_imu = read_pose(x[first]), .additive = Eigen::VectorXd(additive)};
  if (additive > 0) {
    state.additive = Eigen::Map<const Eigen::VectorXd>(x[first + 1], additive);
  }
  return state;
}

// Writes a derivative by a keyframe's errors to its one or two blocks.
void write(const Eigen::MatrixXd& d, double** jacobians, int first) {
  const Eigen::Index additive = d.cols() - kPoseErrors;
  if (jacobians[first] != nullptr) {
    Eigen::Map<RowMajor> J(jacobians[first], d.rows(), kPoseNumbers);
    J.setZero();
    J.leftCols<kPoseErrors>() = d.leftCols<kPoseErrors>();
  }
  if (additive > 0 && jacobians[first + 1] != nullptr) {
    Eigen::Map<RowMajor>(jacobians[first + 1], d.rows(), additive) = d.rightCols(additive);
  }
}

void add_keyframe(int additive, std::vector<std::int32_t>& sizes) {
  sizes.push_back(kPoseNumbers);
  if (additive > 0) sizes.push_back(additive);
}

}  // namespace

template <int Rows>
std::optional<PredictedView<Rows>> StereoTerm<Rows>::see(const SE3& world_T_imu,
                                                         const HomogeneousPoint& point) const {
  const Eigen::Matrix3d cam_R_world = rig->cam0_T_imu.R * world_T_imu.R.transpose();
  const Eigen::Vector3d from_imu = point.p_world - point.w * world_T_imu.p;
  const Eigen::Vector3d q = cam_R_world * from_imu + point.w * rig->cam0_T_imu.p;
  const double z = q.z();
  if (!(z > least_depth * std::max(point.w, kLeastW))) return std::nullopt;
  const double u = rig->fx * q.x() / z, v = rig->fy * q.y() / z;
  const double per_w = rig->fx * rig->baseline / z, disparity = per_w * point.w;
  Eigen::Matrix<double, 4, 3> d_q;
  d_q << rig->fx / z, 0, -u / z,            //
      0, rig->fy / z, -v / z,               //
      rig->fx / z, 0, (disparity - u) / z,  //
      0, rig->fy / z, -v / z;
  const Eigen::Vector4d predicted(u + rig->cx, v + rig->cy, u + rig->cx - disparity, v + rig->cy);
  const Eigen::Matrix<double, Rows, 3> d_cam = whitened_rows * d_q;
  PredictedView<Rows> seen;
  seen.residual = whitened_rows * (predicted - pixels);
  seen.d_point = d_cam * cam_R_world;
  seen.d_w =
      d_cam * rig->cam0_T_imu.p - seen.d_point * world_T_imu.p - per_w * whitened_rows.col(2);
  seen.d_pose << seen.d_point * hat(from_imu), -point.w * seen.d_point;
  return seen;
}

template <int Rows>
StereoTerm<Rows> stereo_term(const StereoRig& rig, StereoRows rows, const StereoNoise& noise,
                             const Eigen::Vector4d& pixels) {
  const Eigen::Vector4d sigma = variances_of(rows, noise).cwiseSqrt();
  return {.rig = &rig,
          .pixels = pixels,
          .whitened_rows = sigma.head<Rows>().cwiseInverse().asDiagonal() * rows_of(rows)};
}

VelocityStartCost::VelocityStartCost(const VelocityStart& start) : start_(&start) {
  const auto additive = static_cast<int>(start.mean.additive.size());
  set_num_residuals(kPoseErrors + additive);
  add_keyframe(additive, *mutable_parameter_block_sizes());
}

bool VelocityStartCost::Evaluate(const double* const* x, double* residuals,
                                 double** jacobians) const {
  const VelocityState& mean = start_->mean;
  const int n = num_residuals();
  const VelocityState state = state_of(x, 0, n - kPoseErrors);
  const Eigen::Vector3d theta = so3::log(state.world_T_imu.R * mean.world_T_imu.R.transpose());
  Eigen::VectorXd e(n);
  e << theta, state.world_T_imu.p - mean.world_T_imu.p, state.additive - mean.additive;
  Eigen::Map<Eigen::VectorXd>(residuals, n) = start_->whitening * e;
  if (jacobians == nullptr) return true;
  Eigen::MatrixXd d = start_->whitening;
  d.leftCols<3>() *= so3::left_jacobian_inverse(theta);
  write(d, jacobians, 0);
  return true;
}

TwistCost::TwistCost(const TwistLink& link) : link_(&link) {
  set_num_residuals(link.size());
  add_keyframe(link.model.size(), *mutable_parameter_block_sizes());
  add_keyframe(link.model.size(), *mutable_parameter_block_sizes());
}

bool TwistCost::Evaluate(const double* const* x, double* residuals, double** jacobians) const {
  const int additive = link_->model.size(), next = additive > 0 ? 2 : 1;
  TwistDerivatives d;
  Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) =
      twist_residual(*link_, state_of(x, 0, additive), state_of(x, next, additive),
                     jacobians != nullptr ? &d : nullptr);
  if (jacobians == nullptr) return true;
  write(d.now, jacobians, 0);
  write(d.next, jacobians, next);
  return true;
}

SampleCost::SampleCost(const BodyVelocityModel& model, const VelocitySample& sample)
    : model_(model), sample_(&sample) {
  set_num_residuals(6);
  if (model.level) mutable_parameter_block_sizes()->push_back(kPoseNumbers);
  mutable_parameter_block_sizes()->push_back(model.size());
}

bool SampleCost::Evaluate(const double* const* x, double* residuals, double** jacobians) const {
  const int additive = model_.level ? 1 : 0;
  State state;
  if (model_.level) state.world_T_imu = read_pose(x[0]);
  state.additive = Eigen::Map<const Eigen::VectorXd>(x[additive], model_.size());
  const Measurement z = measure_velocity(model_, state, sample_->velocity, sample_->noise);
  if (!z.residual.allFinite()) return false;
  const Vector6d weight = z.noise.diagonal().cwiseSqrt().cwiseInverse();
  Eigen::Map<Vector6d>{residuals} = -weight.cwiseProduct(z.residual);
  if (jacobians == nullptr) return true;
  const Eigen::MatrixXd d = weight.asDiagonal() * z.d_core;
  if (model_.level) {
    write(d, jacobians, 0);
  } else if (jacobians[0] != nullptr) {
    Eigen::Map<RowMajor>(jacobians[0], 6, model_.size()) = d;
  }
  return true;
}

template struct StereoTerm<2>;
template struct StereoTerm<3>;
template struct StereoTerm<4>;
template StereoTerm<2> stereo_term(const StereoRig&, StereoRows, const StereoNoise&,
                                   const Eigen::Vector4d&);
template StereoTerm<3> stereo_term(const StereoRig&, StereoRows, const StereoNoise&,
                                   const Eigen::Vector4d&);
template StereoTerm<4> stereo_term(const StereoRig&, StereoRows, const StereoNoise&,
                                   const Eigen::Vector4d&);

}  // namespace chasles::smooth_detail
