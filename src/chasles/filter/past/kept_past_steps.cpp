#include <algorithm>
#include <utility>

#include <chasles/filter/dense.hpp>
#include <chasles/filter/past/kept_past.hpp>
#include <chasles/lie/small_matrices.hpp>

// The steps of the filter: Z <- Z M^T for d+ = M d (latest_segment.hpp), and what History needs.

namespace chasles {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void KeptPast::propagate(const MatrixXd& F, const MatrixXd& Q, const Covariance& covariance) {
  if (keeps_steps()) {
    history_.keep_bound(covariance);
    history_.append(History::Propagation{.F = F, .Q = Q});
  }
  if (map_ == Map::kPast) end_segment_when_due(covariance);
  if (latest_.variables() == 0) return;
  auto of_core = latest_.Z().leftCols(F.cols());
  auto F_transposed = other_.take(F.cols(), F.rows());
  F_transposed = F.transpose();
  auto moved = product_.take(of_core.rows(), F.rows());
  dense::multiply(of_core, F_transposed, moved);
  of_core = moved;
}

void KeptPast::correct(Measurements used, const Whitened& update, const ErrorRef& delta) {
  latest_.correct(update);
  if (keeps_steps()) record(used, delta);
}

void KeptPast::record(Measurements used, const ErrorRef& delta) {
  constexpr int kMaxRows = 6;  // of one measurement, given by its types
  History::Correction& record = correction_;
  record.delta = delta;
  record.core = MatrixXd::Zero(core_, core_);
  record.core_vector = VectorXd::Zero(core_);
  record.landmarks.reserve(used.size());
  for (const Measurement* z : used) {
    const Index w = z->d_core.cols();
    const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxRows, kMaxRows> weight =
        small::inverse_symmetric(z->noise);
    const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, Measurement::kMaxCoreColumns,
                        kMaxRows>
        core = z->d_core.transpose() * weight;
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

void KeptPast::add_outer(const dense::ConstBlock& U, const dense::ConstBlock& V) {
  if (latest_.variables() > 0) {
    auto Z = latest_.Z();
    auto by = product_.take(Z.rows(), V.cols());
    dense::multiply(Z, V, by);
    by *= -1;
    dense::subtract_outer(by, U, Z);
  }
  if (!keeps_steps()) return;
  MatrixXd& A = correction_.A_motion;  // the rotation's rows are the identity's
  const Index motion = A.size() > 0 ? A.rows() : std::min<Index>(core_, 9);
  if (A.size() == 0) A = MatrixXd::Identity(motion, motion);
  A.leftCols<3>() += U.topRows(motion);
  const auto of_landmarks = U.bottomRows(U.rows() - core_);
  if (!of_landmarks.isZero(0)) correction_.A_landmarks = of_landmarks;
}

void KeptPast::add_rotation_of_clone(int row, const Matrix3d& D) {
  if (latest_.variables() == 0) return;
  auto Z = latest_.Z();
  dense::add_turned(Z.middleCols<3>(row), D, Z.middleCols<3>(row + 3));
}

void KeptPast::turn_clone(int row, const Matrix6d& A) {
  if (latest_.variables() == 0) return;
  auto of_clone = latest_.Z().middleCols<6>(row);
  auto turned = product_.take<Eigen::Matrix<double, Eigen::Dynamic, 6>>(of_clone.rows(), 6);
  turned.noalias() = of_clone * A.transpose();
  of_clone = turned;
}

void KeptPast::turn_motion(const MotionMatrix& A) {
  if (latest_.variables() > 0) {
    auto of_motion = latest_.Z().leftCols(A.cols());
    auto turned = product_.take(of_motion.rows(), A.cols());
    turned.noalias() = of_motion * A.transpose();
    of_motion = turned;
  }
  if (keeps_steps()) correction_.A_motion = A;
}

void KeptPast::add_along(const VectorXd& c, int row, const Eigen::Vector3d& by) {
  const VectorXd along = latest_.Z() * c;
  latest_.Z().middleCols<3>(row) += along * by.transpose();
}

void KeptPast::end_correction() {
  if (!keeps_steps()) return;
  history_.append(std::move(correction_));
  correction_ = {};
}

void KeptPast::substitute(int row, std::span<const RowTerm> terms) {
  if (latest_.variables() == 0) return;
  Eigen::Matrix<double, Eigen::Dynamic, 3> columns =
      Eigen::Matrix<double, Eigen::Dynamic, 3>::Zero(latest_.variables(), 3);
  for (const RowTerm& term : terms) {
    columns += latest_.Z().middleCols<3>(term.row) * term.d.transpose();
  }
  latest_.Z().middleCols<3>(row) = columns;
}

void KeptPast::make_cartesian(int row, int clone_row, const Eigen::Matrix<double, 3, 9>& J,
                              std::optional<int> camera_row,
                              const Eigen::Matrix<double, 3, 6>& J_camera) {
  if (latest_.variables() == 0) return;
  auto Z = latest_.Z();
  Eigen::Matrix<double, Eigen::Dynamic, 3> of_point =
      Z.middleCols<6>(clone_row) * J.leftCols<6>().transpose() +
      Z.middleCols<3>(row) * J.rightCols<3>().transpose();
  if (camera_row) of_point += Z.middleCols<6>(*camera_row) * J_camera.transpose();
  Z.middleCols<3>(row) = of_point;
}

void KeptPast::compose(const SE3& imu_T_world, const dense::ConstBlock& J_transposed) {
  for (MapLandmark& landmark : frozen_) {
    landmark.p_world = imu_T_world * landmark.p_world;
    landmark.covariance = imu_T_world.R * landmark.covariance * imu_T_world.R.transpose();
  }
  if (latest_.variables() > 0) latest_.Z() = dense::product(latest_.Z(), J_transposed);
}

void KeptPast::clone_pose() {
  latest_.append_rows(6);
  latest_.Z().rightCols<6>() = latest_.Z().leftCols<6>();
}

void KeptPast::append_function(const MatrixXd& D_transposed) {
  const MatrixXd columns = dense::product(latest_.Z(), D_transposed);
  latest_.append_rows(static_cast<int>(D_transposed.cols()));
  latest_.Z().rightCols(D_transposed.cols()) = columns;
}

void KeptPast::add(std::span<const NewLandmark> landmarks, int first) {
  latest_.append_rows(3 * static_cast<int>(landmarks.size()));
  if (keeps_steps()) record(landmarks);
  if (latest_.variables() == 0) return;
  auto Z = latest_.Z();
  for (const NewLandmark& landmark : landmarks) {
    auto own = Z.middleCols<3>(first);
    own.noalias() = Z.leftCols<6>() * landmark.d_pose.transpose();
    for (const NewLandmark::OfClone& clone : landmark.clones) {
      own.noalias() += Z.middleCols<6>(clone.row) * clone.d.transpose();
    }
    first += 3;
  }
}

// Simultaneously initialised landmarks are recorded in parts. The cost of evaluating the history
// grows with the square of the size of a part, but many small parts are slow too.
void KeptPast::record(std::span<const NewLandmark> landmarks) {
  constexpr std::size_t kMostTogether = 10;
  while (!landmarks.empty()) {
    const auto part = landmarks.first(std::min(kMostTogether, landmarks.size()));
    const auto rows = 3 * static_cast<Index>(part.size());
    History::Addition step{.d_pose = MatrixXd(rows, 6), .noise = MatrixXd(3, rows)};
    Index row = 0;
    for (const NewLandmark& landmark : part) {
      step.d_pose.middleRows<3>(row) = landmark.d_pose;
      step.noise.middleCols<3>(row) = landmark.noise;
      row += 3;
    }
    history_.append(std::move(step));
    landmarks = landmarks.subspan(part.size());
  }
}

}  // namespace chasles
