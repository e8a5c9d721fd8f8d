#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <chasles/error.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/filter/whitening.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Landmarks that begin together are remembered in parts: the work of reading the history grows with
// the square of a part's size, and many small parts are slow for another reason.
constexpr int kRowsOfAnAddition = 30;

constexpr int kMaxRows = 6;  // of one measurement, as its types say
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxRows, kMaxRows>;

}  // namespace

Ekf::Ekf(const ErrorChart& chart, State initial, const MatrixXd& core_covariance, Options options)
    : chart_(&chart),
      options_(options),
      state_(std::move(initial)),
      covariance_(core_covariance),
      history_(core_covariance) {
  if (options_.keep_map && state_.calibration_size() > 0) {
    throw UsageError("estimated extrinsics and time offset need a filter without keep_map");
  }
}

MatrixXd Ekf::core_covariance() const {
  const int n = state_.core_size();
  return covariance_.all().topLeftCorner(n, n);
}

void Ekf::propagate(const Prediction& prediction) {
  state_.world_T_imu = prediction.world_T_imu;
  state_.world_T_imu.R = so3::normalized(state_.world_T_imu.R);
  state_.v_world = prediction.v_world;
  state_.additive = prediction.additive;
  const int n = state_.core_size();
  auto P = covariance_.all();
  P.topRows(n) = (prediction.F * P.topRows(n)).eval();
  P.topLeftCorner(n, n) = (P.topLeftCorner(n, n) * prediction.F.transpose() + prediction.Q).eval();
  P.bottomLeftCorner(P.rows() - n, n) = P.topRightCorner(n, P.cols() - n).transpose();
  if (remembers()) {
    history_.append(History::Propagation{.F = prediction.F, .Q = prediction.Q});
  }
}

Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1> Innovation::whitened() const {
  const auto L = S.llt();
  if (L.info() == Eigen::Success) return L.matrixL().solve(residual);
  return decltype(residual)::Constant(residual.size(), std::numeric_limits<double>::quiet_NaN());
}

double Innovation::normalised_square() const { return whitened().squaredNorm(); }

Innovation Ekf::innovation(const Measurement& z) const {
  const auto P = covariance_.all();
  Innovation result{.residual = z.residual, .S = z.noise};
  if (!z.clones.empty()) {
    const Measurement* one[] = {&z};
    const Jacobian H(one, state_);
    result.S += H.times(H.times_transpose(covariance_));
    return result;
  }
  if (z.landmark < 0) {
    const Eigen::Index w = z.d_core.cols();
    result.S += z.d_core * P.block(z.core_column, z.core_column, w, w) * z.d_core.transpose();
    return result;
  }
  const int row = state_.landmarks[static_cast<std::size_t>(z.landmark)].row;
  const auto d_pose = z.d_core.leftCols<6>();
  const Eigen::Matrix<double, Eigen::Dynamic, 6, 0, kMaxRows, 6> HP_pose =
      d_pose.lazyProduct(P.topLeftCorner<6, 6>()) + z.d_landmark.lazyProduct(P.block<3, 6>(row, 0));
  const Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMaxRows, 3> HP_landmark =
      d_pose.lazyProduct(P.block<6, 3>(0, row)) + z.d_landmark.lazyProduct(P.block<3, 3>(row, row));
  result.S += HP_pose.lazyProduct(d_pose.transpose());
  result.S += HP_landmark.lazyProduct(z.d_landmark.transpose());
  return result;
}

double Ekf::normalised_square(const Measurement& z) const {
  return innovation(z).normalised_square();
}

std::vector<double> Ekf::normalised_squares(std::span<const Measurement> measurements,
                                            const Measurement* given) const {
  std::vector<double> result;
  if (!given) {
    for (const Measurement& z : measurements) result.push_back(normalised_square(z));
    return result;
  }
  const Innovation known = innovation(*given);
  const auto S_known = known.S.ldlt();
  const MatrixXd PHt = covariance_.all().middleCols(given->core_column, given->d_core.cols()) *
                       given->d_core.transpose();
  for (const Measurement& z : measurements) {
    SmallMatrix cross = z.d_core * PHt.middleRows(z.core_column, z.d_core.cols());
    if (z.landmark >= 0) {
      const int row = state_.landmarks[static_cast<std::size_t>(z.landmark)].row;
      cross += z.d_landmark * PHt.middleRows<3>(row);
    }
    for (const Measurement::OfClone& clone : z.clones) {
      cross += clone.d * PHt.middleRows<6>(clone.row);
    }
    Innovation conditional = innovation(z);
    conditional.residual -= cross * S_known.solve(known.residual);
    conditional.S -= cross * S_known.solve(cross.transpose());
    result.push_back(conditional.normalised_square());
  }
  return result;
}

double Ekf::joint_normalised_square(std::span<const Measurement> measurements) const {
  std::vector<const Measurement*> all;
  for (const Measurement& z : measurements) all.push_back(&z);
  const auto z = whiten(all, covariance_, state_);
  return z ? z->w.squaredNorm() : std::numeric_limits<double>::infinity();
}

UpdateReport Ekf::update(std::span<const Measurement> measurements) {
  UpdateReport report;
  std::vector<const Measurement*> accepted;
  for (const Measurement& z : measurements) {
    const bool gated = !std::isinf(z.gate);  // no gate costs nothing
    report.whitened.emplace_back();
    if (gated) report.whitened.back() = innovation(z).whitened();
    // Written so that a NaN is refused.
    const bool inside =
        gated ? report.whitened.back().squaredNorm() < z.gate : z.residual.allFinite();
    report.accepted.push_back(inside);
    if (inside) accepted.push_back(&z);
  }
  if (accepted.empty()) return report;

  const std::optional<Whitened> z = whiten(accepted, covariance_, state_);
  report.failed = !z;
  if (!z) return report;
  report.nis = z->w.squaredNorm();
  report.dof = static_cast<int>(z->w.size());
  History::Correction record;
  record.delta.noalias() = z->W * z->w;
  dense::downdate_lower(z->W, covariance_.all());

  if (remembers()) remember(accepted, record);
  const State before = state_;
  correct_mean(record.delta);
  change_chart(before, record);
  dense::mirror_lower(covariance_.all());
  if (remembers()) history_.append(std::move(record));
  for (const Measurement* used : accepted) {
    if (used->landmark >= 0) {
      ++state_.landmarks[static_cast<std::size_t>(used->landmark)].observations;
    }
  }
  return report;
}

void Ekf::remember(const std::vector<const Measurement*>& used, History::Correction& record) const {
  const int n = state_.core_size();
  record.core = MatrixXd::Zero(n, n);
  record.core_vector = VectorXd::Zero(n);
  record.landmarks.reserve(used.size());
  for (const Measurement* z : used) {
    const Eigen::Index w = z->d_core.cols();
    const SmallMatrix weight = z->noise.inverse();
    const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 16, kMaxRows> core =
        z->d_core.transpose() * weight;
    record.core.block(z->core_column, z->core_column, w, w) += core * z->d_core;
    record.core_vector.segment(z->core_column, w) += core * z->residual;
    if (z->landmark < 0) continue;
    record.landmarks.push_back({
        .index = z->landmark,
        .with_pose = core * z->d_landmark,
        .own = z->d_landmark.transpose() * weight * z->d_landmark,
        .vector = z->d_landmark.transpose() * weight * z->residual,
    });
  }
}

void Ekf::correct_mean(const VectorXd& delta) {
  VectorXd xi = delta;
  push(*chart_, state_, xi);
  retract(*chart_, state_, xi);
  state_.world_T_imu.R = so3::normalized(state_.world_T_imu.R);
  for (Landmark& landmark : retired_) landmark.p_world += delta.segment<3>(landmark.row);
}

// P <- A P A^T with A = T(x+)^-1 T(x), on the lower triangle.
void Ekf::change_chart(const State& before, History::Correction& record) {
  auto P = covariance_.all();
  if (chart_->landmark_block) {
    // A adds B θ to the landmarks' rows: P + B Z^T + Z B^T with Z = P_θ + B P_θθ / 2.
    MatrixXd B = MatrixXd::Zero(P.rows(), 3);
    for (std::size_t i = 0; i < state_.landmarks.size(); ++i) {
      if (state_.landmarks[i].anchor) continue;
      B.middleRows<3>(state_.landmarks[i].row) =
          chart_->landmark_block(before.landmarks[i].p_world) -
          chart_->landmark_block(state_.landmarks[i].p_world);
    }
    const Eigen::Matrix3d P_theta = P.topLeftCorner<3, 3>().selfadjointView<Eigen::Lower>();
    MatrixXd Z = P.leftCols<3>();
    Z.topRows<3>() = P_theta;
    Z += B * (0.5 * P_theta);
    dense::symmetric_update_lower(B, Z, P);
    record.A_landmarks = B.bottomRows(B.rows() - state_.core_size());
  }
  change_chart_of_clones(before);
  const int n = state_.motion_size();
  const MatrixXd after = chart_->motion_block(state_).topLeftCorner(n, n);
  const MatrixXd A = after.partialPivLu().solve(chart_->motion_block(before).topLeftCorner(n, n));
  if (A.isIdentity(0)) return;
  const MatrixXd corner = P.topLeftCorner(n, n).selfadjointView<Eigen::Lower>();
  P.topLeftCorner(n, n) = A * corner * A.transpose();
  auto below = P.bottomLeftCorner(P.rows() - n, n);
  below = (below * A.transpose()).eval();
  record.A_motion = A;
}

// The clones' blocks of the same, each by itself.
void Ekf::change_chart_of_clones(const State& before) {
  auto P = covariance_.all();
  for (std::size_t i = 0; i < state_.clones.size(); ++i) {
    const Clone& clone = state_.clones[i];
    const Matrix6d A = pose_block(*chart_, clone.world_T_imu)
                           .partialPivLu()
                           .solve(pose_block(*chart_, before.clones[i].world_T_imu));
    if (A.isIdentity(0)) continue;
    const int r = clone.row;
    const Matrix6d own = P.block<6, 6>(r, r).selfadjointView<Eigen::Lower>();
    P.block<6, 6>(r, r) = A * own * A.transpose();
    auto left = P.block(r, 0, 6, r);
    left = (A * left).eval();
    auto below = P.block(r + 6, r, P.rows() - r - 6, 6);
    below = (below * A.transpose()).eval();
  }
}

void Ekf::add(std::span<const NewLandmark> landmarks) {
  if (landmarks.empty()) return;
  const int old_size = covariance_.size();
  const int rows = 3 * static_cast<int>(landmarks.size());
  covariance_.append(rows);
  auto P = covariance_.all();
  MatrixXd d_pose(rows, 6);
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    d_pose.middleRows<3>(3 * static_cast<int>(i)) = landmarks[i].d_pose;
  }
  MatrixXd cross = d_pose * P.topLeftCorner(6, old_size);
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    for (const NewLandmark::OfClone& clone : landmarks[i].clones) {
      cross.middleRows<3>(3 * static_cast<int>(i)) += clone.d * P.block(clone.row, 0, 6, old_size);
    }
  }
  P.block(old_size, 0, rows, old_size) = cross;
  P.block(0, old_size, old_size, rows) = cross.transpose();
  MatrixXd own = cross.leftCols<6>() * d_pose.transpose();
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    for (const NewLandmark::OfClone& clone : landmarks[i].clones) {
      own.middleCols<3>(3 * static_cast<int>(i)) +=
          cross.middleCols<6>(clone.row) * clone.d.transpose();
    }
  }
  P.block(old_size, old_size, rows, rows) = own;
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const int row = old_size + 3 * static_cast<int>(i);
    P.block<3, 3>(row, row) += landmarks[i].noise;
    state_.landmarks.push_back({.id = landmarks[i].id,
                                .p_world = landmarks[i].p_world,
                                .row = row,
                                .observations = landmarks[i].observations,
                                .anchor = landmarks[i].anchor,
                                .cam_T_imu = landmarks[i].cam_T_imu,
                                .inverse_depth = landmarks[i].inverse_depth,
                                .camera = landmarks[i].camera});
    state_.landmarks.back().first = state_.p_world(state_.landmarks.back());
  }
  if (!remembers()) return;
  for (int first = 0; first < rows; first += kRowsOfAnAddition) {
    const int count = std::min(kRowsOfAnAddition, rows - first);
    History::Addition step{.d_pose = d_pose.middleRows(first, count), .noise = MatrixXd(3, count)};
    for (int row = 0; row < count; row += 3) {
      step.noise.middleCols<3>(row) = landmarks[static_cast<std::size_t>((first + row) / 3)].noise;
    }
    history_.append(std::move(step));
  }
}

}  // namespace chasles
