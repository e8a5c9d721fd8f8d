#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <chasles/filter/dense.hpp>
#include <chasles/filter/ekf.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Landmarks that begin together are remembered in parts: the work of reading the history grows with
// the square of a part's size, and many small parts are slow for another reason.
constexpr int kRowsOfAnAddition = 30;

constexpr int kMaxRows = 6;  // of one measurement, as its types say
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxRows, kMaxRows>;

// Rows that are applied together: with fewer, the small factorisations of S would not fill BLAS's
// kernels; with more, their cost would grow with the square.
constexpr Eigen::Index kBlockRows = 64;

using Used = std::span<const Measurement* const>;

// The measurements from the first on that fit into one block.
std::size_t block_size(Used z) {
  std::size_t count = 0;
  Eigen::Index rows = 0;
  while (count < z.size() && (count == 0 || rows + z[count]->residual.size() <= kBlockRows)) {
    rows += z[count++]->residual.size();
  }
  return count;
}

Eigen::Index rows_of(Used z) {
  Eigen::Index m = 0;
  for (const Measurement* one : z) m += one->residual.size();
  return m;
}

// Some measurements as one, given a covariance and the correction `delta` that others have made:
// residual, P H^T and the lower triangle of S = H P H^T + R. Of P the lower triangle is read.
struct Stack {
  VectorXd residual;
  MatrixXd PHt, S;
};

Stack stack(Used measurements, const Covariance& covariance, const State& x,
            const VectorXd& delta) {
  const Eigen::Index m = rows_of(measurements);
  const Eigen::Index core = x.core_size();
  const auto P = covariance.all();
  const Eigen::Index n = P.rows();
  MatrixXd d_core = MatrixXd::Zero(m, core);
  Stack result{VectorXd(m), MatrixXd(n, m), {}};
  Eigen::Index at = 0;
  for (const Measurement* z : measurements) {
    const Eigen::Index k = z->residual.size();
    d_core.block(at, z->core_column, k, z->d_core.cols()) = z->d_core;
    result.residual.segment(at, k) = z->residual;
    at += k;
  }
  const MatrixXd of_core = dense::symmetric_rows(P, 0, core).transpose();
  result.PHt = dense::product(of_core, d_core.transpose().eval());
  result.residual.noalias() -= d_core * delta.head(core);
  Eigen::Matrix<double, Eigen::Dynamic, 3> of_landmark(n, 3);
  at = 0;
  for (const Measurement* z : measurements) {
    const Eigen::Index k = z->residual.size();
    if (z->landmark >= 0) {
      const Eigen::Index row = x.landmarks[static_cast<std::size_t>(z->landmark)].row;
      of_landmark.topRows(row) = P.block(row, 0, 3, row).transpose();
      of_landmark.bottomRows(n - row) = P.block(row, row, n - row, 3);
      of_landmark.middleRows<3>(row) = P.block<3, 3>(row, row).selfadjointView<Eigen::Lower>();
      for (Eigen::Index i = 0; i < k; ++i) {
        const Eigen::RowVector3d d = z->d_landmark.row(i);
        result.PHt.col(at + i) +=
            d[0] * of_landmark.col(0) + d[1] * of_landmark.col(1) + d[2] * of_landmark.col(2);
      }
      result.residual.segment(at, k) -= z->d_landmark * delta.segment<3>(row);
    }
    at += k;
  }
  result.S = dense::product(d_core, result.PHt.topRows(core));
  at = 0;
  for (const Measurement* z : measurements) {
    const Eigen::Index k = z->residual.size();
    if (z->landmark >= 0) {
      const Eigen::Index row = x.landmarks[static_cast<std::size_t>(z->landmark)].row;
      result.S.block(at, 0, k, at + k) +=
          z->d_landmark.lazyProduct(result.PHt.block(row, 0, 3, at + k));
    }
    result.S.block(at, at, k, k) += z->noise;
    at += k;
  }
  return result;
}

}  // namespace

Ekf::Ekf(const ErrorChart& chart, State initial, const MatrixXd& core_covariance, Options options)
    : chart_(&chart),
      options_(options),
      state_(std::move(initial)),
      covariance_(core_covariance),
      history_(core_covariance) {}

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
  if (options_.compress_map) {
    history_.append(History::Propagation{.F = prediction.F, .Q = prediction.Q});
  }
}

double Innovation::normalised_square() const { return residual.dot(S.ldlt().solve(residual)); }

Innovation Ekf::innovation(const Measurement& z) const {
  const auto P = covariance_.all();
  const Eigen::Index w = z.d_core.cols();
  Innovation result{.residual = z.residual, .S = z.noise};
  result.S += z.d_core * P.block(z.core_column, z.core_column, w, w) * z.d_core.transpose();
  if (z.landmark >= 0) {
    const int row = state_.landmarks[static_cast<std::size_t>(z.landmark)].row;
    const SmallMatrix cross =
        z.d_core * P.block(z.core_column, row, w, 3) * z.d_landmark.transpose();
    result.S += cross + cross.transpose();
    result.S += z.d_landmark * P.block<3, 3>(row, row) * z.d_landmark.transpose();
  }
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
    Innovation conditional = innovation(z);
    conditional.residual -= cross * S_known.solve(known.residual);
    conditional.S -= cross * S_known.solve(cross.transpose());
    result.push_back(conditional.normalised_square());
  }
  return result;
}

UpdateReport Ekf::update(std::span<const Measurement> measurements) {
  UpdateReport report;
  std::vector<const Measurement*> accepted;
  for (const Measurement& z : measurements) {
    // Written so that a NaN is refused, and so that no gate costs nothing.
    const bool inside = std::isinf(z.gate) ? z.residual.allFinite() : normalised_square(z) < z.gate;
    report.accepted.push_back(inside);
    if (inside) accepted.push_back(&z);
  }
  if (accepted.empty()) return report;

  // The gain is never formed: with S = L L^T, W = L^-1 H P and w = L^-1 r, the correction is W^T w
  // and the covariance loses W^T W. Block by block at one linearisation this is the update with all
  // at once; the upper triangle keeps what was before until all blocks are in.
  History::Correction record;
  record.delta = VectorXd::Zero(covariance_.size());
  const VectorXd diagonal_before = covariance_.all().diagonal();
  for (Used rest = accepted; !rest.empty();) {
    const std::size_t count = block_size(rest);
    Stack z = stack(rest.first(count), covariance_, state_, record.delta);
    rest = rest.subspan(count);
    if (!dense::cholesky(z.S)) {
      covariance_.all().diagonal() = diagonal_before;
      dense::mirror_upper(covariance_.all());
      report.nis = 0;
      report.dof = 0;
      report.failed = true;
      return report;
    }
    dense::solve_lower_from_right(z.S, z.PHt);
    dense::solve_lower(z.S, z.residual);
    report.nis += z.residual.squaredNorm();
    report.dof += static_cast<int>(z.residual.size());
    record.delta.noalias() += z.PHt * z.residual;
    dense::downdate_lower(z.PHt, covariance_.all());
  }

  if (options_.compress_map) remember(accepted, record);
  const State before = state_;
  correct_mean(record.delta);
  change_chart(before, record);
  dense::mirror_lower(covariance_.all());
  if (options_.compress_map) history_.append(std::move(record));
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
  chart_->retract(state_, xi);
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
  const int n = state_.additive_row();
  const MatrixXd after = chart_->motion_block(state_).topLeftCorner(n, n);
  const MatrixXd A = after.partialPivLu().solve(chart_->motion_block(before).topLeftCorner(n, n));
  if (A.isIdentity(0)) return;
  const MatrixXd corner = P.topLeftCorner(n, n).selfadjointView<Eigen::Lower>();
  P.topLeftCorner(n, n) = A * corner * A.transpose();
  auto below = P.bottomLeftCorner(P.rows() - n, n);
  below = (below * A.transpose()).eval();
  record.A_motion = A;
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
  P.block(old_size, 0, rows, old_size) = d_pose * P.topLeftCorner(6, old_size);
  P.block(0, old_size, old_size, rows) = P.block(old_size, 0, rows, old_size).transpose();
  P.block(old_size, old_size, rows, rows) = P.block(old_size, 0, rows, 6) * d_pose.transpose();
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const int row = old_size + 3 * static_cast<int>(i);
    P.block<3, 3>(row, row) += landmarks[i].noise;
    state_.landmarks.push_back(
        {.id = landmarks[i].id, .p_world = landmarks[i].p_world, .row = row, .observations = 1});
  }
  if (!options_.compress_map) return;
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
