#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/QR>

#include <chasles/base/median.hpp>
#include <chasles/calibrate/corner_loss.hpp>
#include <chasles/calibrate/inertial_problem_detail.hpp>
#include <chasles/imu/imu_buffer.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles::calibrate_detail {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Matrix32d = Eigen::Matrix<double, 3, 2>;

constexpr double kAccelerometerBiasSigma = 0.5, kGyroscopeBiasSigma = 0.1, kVelocitySigma = 10;
constexpr double kScaleSigma = 0.005, kMisalignmentSigma = 0.002;
constexpr double kOffsetSigma = 1, kReadoutSigma = 0.02;

constexpr double kAhead = 0.02;  // as long as a readout [s]

// The root L of the covariance L L^T that the noise of single samples gives to an angular rate and
// half of its change, by a sample now and one kAhead later.
Eigen::Matrix2d rate_root(const std::vector<ImuSample>& imu, double noise_density) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < imu.size(); ++i) {
    intervals.push_back(to_seconds(imu[i].time - imu[i - 1].time));
  }
  const double sigma = noise_density / std::sqrt(median(std::move(intervals)));
  Eigen::Matrix2d root;
  root << sigma, 0, -sigma / (2 * kAhead), sigma / (2 * kAhead);
  return root;
}

// Whitens residuals that have errors of unit variance in common besides, of which `by_common` is
// the derivative: their covariance is 1 + B B^T. Returns by how much half of their squares falls.
double whiten_common(const MatrixXd& by_common, MatrixXd& by_state, MatrixXd& by_border,
                     VectorXd& r) {
  const Eigen::Index n = by_common.cols();
  const Eigen::HouseholderQR<MatrixXd> qr(by_common);
  const MatrixXd Q = qr.householderQ() * MatrixXd::Identity(by_common.rows(), n);
  const MatrixXd U = qr.matrixQR().topRows(n).triangularView<Eigen::Upper>();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(U * U.transpose());
  const VectorXd less = 1 - (1 + eigen.eigenvalues().array().max(0)).rsqrt();
  const MatrixXd QV = Q * eigen.eigenvectors();
  const auto whiten = [&](auto& rows) {
    rows -= (QV * (less.asDiagonal() * (QV.transpose() * rows)).eval()).eval();
  };
  const double before = r.squaredNorm();
  whiten(by_state);
  whiten(by_border);
  whiten(r);
  return (before - r.squaredNorm()) / 2;
}

}  // namespace

Matrix32d across(const Vector3d& gravity) {
  Matrix32d E;
  E.col(0) = gravity.unitOrthogonal();
  E.col(1) = gravity.normalized().cross(E.col(0));
  return E;
}

InertialMotion::InertialMotion(const InertialState& x, const InertialRig& rig,
                               const InertialInstant& at, double seconds)
    : acceleration(rig.gravity[at.recording]), delay(seconds) {
  const ImuSample sample = corrected(rig.imu, at.sample);
  const Vector3d now = sample.angular_rate_imu - x.gyroscope_bias;
  rate = now + 2 * seconds * at.rate_change;
  acceleration += x.world_T_imu.R * (sample.specific_force_imu - x.accelerometer_bias);
  v_world = x.v_world + seconds * acceleration;
  world_T_imu.R = x.world_T_imu.R * so3::exp(seconds * now + seconds * seconds * at.rate_change);
  world_T_imu.p = x.world_T_imu.p + seconds * x.v_world + seconds * seconds / 2 * acceleration;
}

VectorXd prior_sigmas(const InertialCalibrationInput& input, const InertialLayout& layout,
                      const ImuCorrection& imu) {
  VectorXd sigmas = VectorXd::Constant(layout.rows(), std::numeric_limits<double>::infinity());
  for (int i = 0; i < imu.size(); ++i) {
    sigmas[layout.imu_row() + i] = i < ImuCorrection::kScales ? kScaleSigma : kMisalignmentSigma;
  }
  sigmas.tail(layout.shape_rows()) = input.cameras.shape.sigma;
  return sigmas;
}

void InertialProblem::make_links(const InertialRig& x, double gyroscope_factor,
                                 double accelerometer_factor) {
  ImuBuffer buffer({.convention = input_.convention});
  for (const ImuSample& sample : input_.imu) buffer.add(sample);
  ImuNoise noise = input_.noise;
  noise.gyroscope_noise_density *= gyroscope_factor;
  noise.gyroscope_random_walk *= gyroscope_factor;
  noise.accelerometer_noise_density *= accelerometer_factor;
  noise.accelerometer_random_walk *= accelerometer_factor;
  rate_root_ = rate_root(input_.imu, noise.gyroscope_noise_density);
  links_.assign(instants_.size(), std::nullopt);
  for (std::size_t k = 0; k < instants_.size(); ++k) {
    instants_[k].sample = buffer.at(instants_[k].time).value();
    const Time ahead = instants_[k].time + from_seconds(kAhead);
    instants_[k].rate_change =
        (buffer.at(ahead)->angular_rate_imu - instants_[k].sample.angular_rate_imu) / (2 * kAhead);
    if (k + 1 == instants_.size()) break;
    if (to_seconds(instants_[k + 1].time - instants_[k].time) > kLongestLink) continue;
    links_[k] = imu_link(buffer.between(instants_[k].time, instants_[k + 1].time),
                         x.states[k].biases(), noise);
  }
}

std::optional<LinearisedRig> InertialProblem::linearised(const InertialRig& x) const {
  LinearisedRig result{{instants_.size(), 15, layout_.rows()}, 0};
  for (std::size_t k = 0; k < instants_.size(); ++k) {
    for (const TargetView* view : instants_[k].views) {
      if (!add_view(x, k, *view, result)) return std::nullopt;
    }
    const bool begins = k == 0 || !links_[k - 1];
    if (begins) add_first(x, k, result);
    if (links_[k]) add_link(x, k, result);
  }
  add_priors(x, result);
  return result;
}

std::optional<LinearisedRig> InertialProblem::pixels_alone(const InertialRig& x) const {
  LinearisedRig result{{instants_.size(), 15, layout_.rows()}, 0};
  const MatrixXd none(15, 0);
  for (std::size_t k = 0; k < instants_.size(); ++k) {
    for (const TargetView* view : instants_[k].views) {
      if (!add_view(x, k, *view, result)) return std::nullopt;
    }
    result.equations.add(k, 1e-3 * MatrixXd::Identity(15, 15), none, {}, VectorXd::Zero(15));
  }
  result.equations.add_border(1e-6 * MatrixXd::Identity(layout_.rows(), layout_.rows()),
                              columns_from(0, layout_.rows()), VectorXd::Zero(layout_.rows()));
  return result;
}

std::optional<InertialRig> InertialProblem::moved(const InertialRig& x,
                                                  const ChainEquations::Step& step) const {
  InertialRig next = x;
  const VectorXd& d = step.border;
  for (std::size_t c = 0; c < layout_.cameras(); ++c) {
    const auto camera =
        chasles::moved(x.cameras[c], d.segment(layout_.lens_row(c), layout_.lens(c).parameters()));
    if (!camera) return std::nullopt;
    next.cameras[c] = *camera;
    move(next.cameras[c].cam_T_imu, d.segment<6>(layout_.pose_row(c)));
    next.offsets[c] += d[layout_.offset_row(c)];
    if (layout_.has_readout()) next.cameras[c].shutter.readout += d[layout_.readout_row(c)];
  }
  for (std::size_t r = 0; r < x.gravity.size(); ++r) {
    const Vector3d& g = x.gravity[r];
    next.gravity[r] = so3::exp(across(g) * d.segment<2>(layout_.gravity_row(r))) * g;
  }
  if (x.imu.size() > 0) next.imu.add(d.segment(layout_.imu_row(), x.imu.size()));
  next.shape += d.tail(layout_.shape_rows());
  for (std::size_t k = 0; k < x.states.size(); ++k) {
    InertialState& state = next.states[k];
    move(state.world_T_imu, step.blocks[k].head<6>());
    state.v_world += step.blocks[k].segment<3>(6);
    state.accelerometer_bias += step.blocks[k].segment<3>(9);
    state.gyroscope_bias += step.blocks[k].segment<3>(12);
  }
  return next;
}

std::vector<Vector2d> InertialProblem::errors(const InertialRig& x, std::size_t k,
                                              const TargetView& view) const {
  std::vector<Vector2d> result;
  const auto c = static_cast<std::size_t>(view.camera);
  for (std::size_t i = 0; i < view.ids.size(); ++i) {
    const InertialMotion motion(x.states[k], x, instants_[k], delay(x, k, view, view.pixels[i]));
    const Vector3d p_imu = motion.world_T_imu.inverse() * corners_.at(view.ids[i], x.shape);
    const auto image = project(x.cameras[c], x.cameras[c].cam_T_imu * p_imu);
    if (!image) return {};
    result.push_back(view.pixels[i] - image->pixel);
  }
  return result;
}

std::pair<double, double> InertialProblem::link_squares(const InertialRig& x) const {
  double rotation = 0, motion = 0, links = 0;
  for (std::size_t k = 0; k < links_.size(); ++k) {
    if (!links_[k]) continue;
    const Vector15d r = link_residual(chasles::corrected(x.imu, *links_[k]), x.states[k],
                                      x.states[k + 1], x.gravity[instants_[k].recording]);
    // W is lower triangular: the first rows are of the rotation alone.
    rotation += r.head<3>().squaredNorm() / 3;
    motion += r.segment<6>(3).squaredNorm() / 6;
    ++links;
  }
  return {rotation / std::max(1.0, links), motion / std::max(1.0, links)};
}

double InertialProblem::delay(const InertialRig& x, std::size_t k, const TargetView& view,
                              const Vector2d& pixel) const {
  const auto c = static_cast<std::size_t>(view.camera);
  return to_seconds(view.time - instants_[k].time) + x.offsets[c] +
         x.cameras[c].shutter.readout * line_part(x.cameras[c], pixel);
}

bool InertialProblem::add_view(const InertialRig& x, std::size_t k, const TargetView& view,
                               LinearisedRig& result) const {
  const auto c = static_cast<std::size_t>(view.camera);
  const Camera& camera = x.cameras[c];
  const int lens = layout_.lens(c).parameters(), shape = layout_.shape_rows();
  const int of_camera = lens + 7 + (layout_.has_readout() ? 1 : 0), imu = x.imu.size();
  const int border = of_camera + imu + shape;
  // What the corrections of the IMU do to the motion while lines are read.
  const ImuCorrection::Derivative by_imu_errors = x.imu.derivative(
      instants_[k].sample.specific_force_imu, instants_[k].sample.angular_rate_imu);
  const MatrixXd by_coordinates = by_search_coordinates(
      layout_.lens(c), search_coordinates(layout_.lens(c), lens_parameters(camera)));
  const Matrix3d& R = x.states[k].world_T_imu.R;
  const auto rows = 2 * static_cast<Eigen::Index>(view.ids.size());
  MatrixXd by_state = MatrixXd::Zero(rows, 15), by_border(rows, border);
  MatrixXd by_rates(rows, layout_.has_readout() ? 6 : 0);  // by its unit errors, and its change's
  VectorXd r(rows);
  for (std::size_t i = 0; i < view.ids.size(); ++i) {
    const InertialMotion motion(x.states[k], x, instants_[k], delay(x, k, view, view.pixels[i]));
    const Vector3d arm = corners_.at(view.ids[i], x.shape) - motion.world_T_imu.p;
    const Matrix3d imu_R_world = motion.world_T_imu.R.transpose();
    const Vector3d p_imu = imu_R_world * arm;
    const Vector3d turned = camera.cam_T_imu.R * p_imu, p_cam = turned + camera.cam_T_imu.p;
    const auto image = project(camera, p_cam);
    if (!image) return false;
    const auto row = 2 * static_cast<Eigen::Index>(i);
    const Vector2d error = (image->pixel - view.pixels[i]) / sigma_;
    const WeightedCorner w = weighted_corner(error.norm());
    const double factor = w.root_weight / sigma_;
    const Eigen::Matrix<double, 2, 3> by_imu = factor * image->d_point * camera.cam_T_imu.R;
    const Eigen::Matrix<double, 2, 3> by_world = by_imu * imu_R_world;
    by_state.block<2, 3>(row, 0) = by_world * hat(arm);
    by_state.block<2, 3>(row, 3) = -by_world;
    by_state.block<2, 3>(row, 6) = -motion.delay * by_world;
    const Eigen::Matrix<double, 2, 3> by_force = -motion.delay * motion.delay / 2 * by_world * R;
    const Eigen::Matrix<double, 2, 3> by_rate = motion.delay * by_world * hat(arm) * R;
    by_state.block<2, 3>(row, 9) = -by_force;
    by_state.block<2, 3>(row, 12) = -by_rate;
    if (imu > 0) {
      by_border.block(row, of_camera, 2, imu) =
          by_force * by_imu_errors.topRows<3>() + by_rate * by_imu_errors.bottomRows<3>();
    }
    by_border.block(row, 0, 2, lens) =
        factor * *parameter_derivative(camera, p_cam) * by_coordinates;
    by_border.block<2, 3>(row, lens) = -factor * image->d_point * hat(turned);
    by_border.block<2, 3>(row, lens + 3) = factor * image->d_point;
    // The point moves in the IMU's frame as time goes on.
    const Vector2d by_time = by_imu * (-motion.rate.cross(p_imu) - imu_R_world * motion.v_world);
    by_border.block<2, 1>(row, lens + 6) = by_time;
    if (layout_.has_readout()) {
      by_border.block<2, 1>(row, lens + 7) = line_part(camera, view.pixels[i]) * by_time;
      by_rates.block<2, 3>(row, 0) = (rate_root_(0, 0) + motion.delay * rate_root_(1, 0)) * by_rate;
      by_rates.block<2, 3>(row, 3) = motion.delay * rate_root_(1, 1) * by_rate;
    }
    if (shape > 0) {
      by_border.block(row, of_camera + imu, 2, shape) =
          by_world * corners_.by_parameters(view.ids[i]);
    }
    r.segment<2>(row) = w.root_weight * error;
    result.cost += w.cost;
  }
  if (layout_.has_readout()) result.cost -= whiten_common(by_rates, by_state, by_border, r);
  std::vector<int> columns = columns_from(layout_.lens_row(c), of_camera);
  for (int i = 0; i < imu; ++i) columns.push_back(layout_.imu_row() + i);
  for (int i = 0; i < shape; ++i) columns.push_back(layout_.shape_row() + i);
  result.equations.add(k, by_state, by_border, columns, r);
  return true;
}

void InertialProblem::add_first(const InertialRig& x, std::size_t k, LinearisedRig& result) const {
  VectorXd r(9);
  r << x.states[k].v_world / kVelocitySigma,
      x.states[k].accelerometer_bias / kAccelerometerBiasSigma,
      x.states[k].gyroscope_bias / kGyroscopeBiasSigma;
  MatrixXd J = MatrixXd::Zero(9, 15);
  J.block<3, 3>(0, 6) = Matrix3d::Identity() / kVelocitySigma;
  J.block<3, 3>(3, 9) = Matrix3d::Identity() / kAccelerometerBiasSigma;
  J.block<3, 3>(6, 12) = Matrix3d::Identity() / kGyroscopeBiasSigma;
  result.equations.add(k, J, MatrixXd(9, 0), {}, r);
  result.cost += r.squaredNorm() / 2;
}

void InertialProblem::add_link(const InertialRig& x, std::size_t k, LinearisedRig& result) const {
  const ImuLink link = chasles::corrected(x.imu, *links_[k]);
  const std::size_t recording = instants_[k].recording;
  const Vector3d& gravity = x.gravity[recording];
  LinkDerivatives d;
  const Vector15d r = link_residual(link, x.states[k], x.states[k + 1], gravity, &d);
  const double t = to_seconds(instants_[k + 1].time - instants_[k].time);
  const Matrix3d Rt = x.states[k].world_T_imu.R.transpose();
  Eigen::Matrix<double, 15, 3> by_gravity = Eigen::Matrix<double, 15, 3>::Zero();
  by_gravity.middleRows<3>(3) = -t * t / 2 * Rt;
  by_gravity.middleRows<3>(6) = -t * Rt;
  const int imu = x.imu.size();
  MatrixXd by_border(15, 2 + imu);
  by_border.leftCols<2>() = link.whitening * by_gravity * -hat(gravity) * across(gravity);
  if (imu > 0) {
    by_border.rightCols(imu) = link_by_imu(*links_[k], x.imu, x.states[k], x.states[k + 1]);
  }
  std::vector<int> columns = columns_from(layout_.gravity_row(recording), 2);
  for (int i = 0; i < imu; ++i) columns.push_back(layout_.imu_row() + i);
  result.equations.add_link(k, d.now, d.next, by_border, columns, r);
  result.cost += r.squaredNorm() / 2;
}

void InertialProblem::add_prior(int row, double value, double sigma, LinearisedRig& result) const {
  const VectorXd r = VectorXd::Constant(1, value / sigma);
  result.equations.add_border(MatrixXd::Constant(1, 1, 1 / sigma), std::vector<int>{row}, r);
  result.cost += r.squaredNorm() / 2;
}

void InertialProblem::add_priors(const InertialRig& x, LinearisedRig& result) const {
  for (std::size_t c = 0; c < layout_.cameras(); ++c) {
    for (const LensPrior& prior : lens_priors(layout_.lens(c))) {
      add_prior(layout_.lens_row(c) + prior.parameter,
                lens_parameters(x.cameras[c])[prior.parameter] - prior.mean, prior.sigma, result);
    }
    add_prior(layout_.offset_row(c), x.offsets[c], kOffsetSigma, result);
    if (layout_.has_readout()) {
      add_prior(layout_.readout_row(c), x.cameras[c].shutter.readout - kReadoutSigma, kReadoutSigma,
                result);
    }
  }
  const VectorXd sigmas = prior_sigmas(input_, layout_, x.imu);
  const VectorXd imu = x.imu.size() > 0 ? VectorXd(x.imu.parameters()) : VectorXd(0);
  for (int i = 0; i < x.imu.size(); ++i) {
    add_prior(layout_.imu_row() + i, imu[i], sigmas[layout_.imu_row() + i], result);
  }
  for (int i = 0; i < layout_.shape_rows(); ++i) {
    add_prior(layout_.shape_row() + i, x.shape[i], sigmas[layout_.shape_row() + i], result);
  }
}

}  // namespace chasles::calibrate_detail
