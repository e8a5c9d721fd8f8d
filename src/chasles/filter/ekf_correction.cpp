#include <chasles/filter/considered_map.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/lie/small_matrices.hpp>
#include <chasles/lie/so3.hpp>

// Correction of the mean, and of the covariance for the change of the chart and of the scale.

namespace chasles {

using Eigen::VectorXd;
using MotionMatrix = KeptPast::MotionMatrix;

void Ekf::correct_mean(State& x, const ErrorRef& delta) const {
  auto xi = work_.xi.take<VectorXd>(delta.size());
  xi = delta;
  push(*chart_, x, xi);
  retract(*chart_, x, xi);
  x.world_T_imu.R = so3::normalized(x.world_T_imu.R);
  if (x.considered) put_considered_in_place(past_.left(), delta, x);
}

namespace {

// Whether T adds multiples of the rotation's error to the others, and changes no more.
template <class Matrix>
bool adds_rotation_only(const Matrix& T) {
  const Eigen::Index others = T.cols() - 3;
  return T.topRows(3).isIdentity(0) && T.bottomRightCorner(others, others).isIdentity(0);
}

}  // namespace

// P <- A P A^T on the lower triangle, with A = T(x+)^-1 T(x), then the change of scale. But for the
// clones, A = I + U V^T with three columns of the rotation's error and one of the scale's.
void Ekf::change_chart(const State& before) {
  change_chart_of_clones(before);
  const Eigen::Index rows = covariance_.size();
  auto U = work_.B.take(rows, 4), V = work_.Z.take(rows, 4);
  U.setZero();
  V.setZero();
  const bool rotation = change_chart_by_rotation(before, U.leftCols<3>());
  V.topLeftCorner<3, 3>().setIdentity();
  const bool scale = keep_scale_ && change_of_scale(before, U.col(3), V.col(3));
  if (rotation && scale) V.col(3).head<3>() += U.leftCols<3>().transpose() * V.col(3);
  const Eigen::Index first = rotation ? 0 : 3, end = scale ? 4 : 3;
  if (first < end) add_outer(U.middleCols(first, end - first), V.middleCols(first, end - first));
}

// The part of the motion and of the landmarks: A = I + B [I 0]. False where B is zero.
bool Ekf::change_chart_by_rotation(const State& before, Eigen::Ref<Eigen::MatrixXd> B) {
  const int n = state_.motion_size();
  const MotionMatrix after = chart_->motion_block(state_).topLeftCorner(n, n);
  MotionMatrix A = chart_->motion_block(before).topLeftCorner(n, n);
  if (adds_rotation_only(after) && adds_rotation_only(A)) {
    B.middleRows(3, n - 3) = (A - after).bottomLeftCorner(n - 3, 3);
  } else {
    small::solve(after, A);
    change_chart_of_motion(A);
  }
  if (chart_->landmark_block) {
    for (std::size_t i = 0; i < state_.landmarks.size(); ++i) {
      if (state_.landmarks[i].anchor) continue;
      B.middleRows<3>(state_.landmarks[i].row) =
          chart_->landmark_block(before.landmarks[i].p_world) -
          chart_->landmark_block(state_.landmarks[i].p_world);
    }
  }
  return !B.isZero(0);
}

// P <- (I + U V^T) P (I + V U^T) = P + U Y^T + Y U^T with Y = P V + U V^T P V / 2.
void Ekf::add_outer(const dense::ConstBlock& U, const dense::ConstBlock& V) {
  auto P = covariance_.all();
  auto PV = work_.product.take(V.rows(), V.cols());
  PV.setZero();
  for (Eigen::Index k = 0; k < V.cols(); ++k) dense::add_symmetric_product(P, V.col(k), PV.col(k));
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 4, 4> half =
      0.5 * V.transpose() * PV;
  auto Y = work_.other.take(PV.rows(), PV.cols());
  Y = PV;
  Y.noalias() += U * half;
  dense::symmetric_update_lower(U, Y, P);
  past_.add_outer(U, V);
}

void Ekf::change_chart_of_motion(const MotionMatrix& A) {
  if (A.isIdentity(0)) return;
  auto P = covariance_.all();
  const Eigen::Index n = A.rows();
  const MotionMatrix corner = P.topLeftCorner(n, n).selfadjointView<Eigen::Lower>();
  P.topLeftCorner(n, n) = A * corner * A.transpose();
  auto below = P.bottomLeftCorner(P.rows() - n, n);
  auto turned = work_.product.take(below.rows(), n);
  turned.noalias() = below * A.transpose();
  below = turned;
  past_.turn_motion(A);
}

// The blocks of the clones in the same transformation, one by one.
void Ekf::change_chart_of_clones(const State& before) {
  for (std::size_t i = 0; i < state_.clones.size(); ++i) {
    const Clone& clone = state_.clones[i];
    const Matrix6d after = pose_block(*chart_, clone.world_T_imu);
    const Matrix6d T = pose_block(*chart_, before.clones[i].world_T_imu);
    if (adds_rotation_only(after) && adds_rotation_only(T)) {
      add_rotation_of_clone(clone.row, (T - after).bottomLeftCorner<3, 3>());
    } else {
      turn_clone(clone.row, solve(after, T));
    }
  }
}

// The position's errors of a clone gain D times those of its rotation.
void Ekf::add_rotation_of_clone(int row, const Eigen::Matrix3d& D) {
  if (D.isZero(0)) return;
  auto P = covariance_.all();
  const Eigen::Index below = P.rows() - row - 6;
  P.block(row + 3, 0, 3, row) += D.lazyProduct(P.block(row, 0, 3, row));
  const Eigen::Matrix3d rotation = P.block<3, 3>(row, row).selfadjointView<Eigen::Lower>();
  const Eigen::Matrix3d cross = D * rotation, with = P.block<3, 3>(row + 3, row);
  P.block<3, 3>(row + 3, row) += cross;
  P.block<3, 3>(row + 3, row + 3) +=
      D * with.transpose() + with * D.transpose() + cross * D.transpose();
  dense::add_turned(P.block(row + 6, row, below, 3), D, P.block(row + 6, row + 3, below, 3));
  past_.add_rotation_of_clone(row, D);
}

void Ekf::turn_clone(int row, const Matrix6d& A) {
  if (A.isIdentity(0)) return;
  auto P = covariance_.all();
  const Matrix6d own = P.block<6, 6>(row, row).selfadjointView<Eigen::Lower>();
  P.block<6, 6>(row, row) = A * own * A.transpose();
  auto left = P.block(row, 0, 6, row);
  auto turned = work_.product.take<Eigen::Matrix<double, 6, Eigen::Dynamic>>(6, row);
  turned.noalias() = A * left;
  left = turned;
  auto below = P.block(row + 6, row, P.rows() - row - 6, 6);
  auto turned_below = work_.product.take<Eigen::Matrix<double, Eigen::Dynamic, 6>>(below.rows(), 6);
  turned_below.noalias() = below * A.transpose();
  below = turned_below;
  past_.turn_clone(row, A);
}

}  // namespace chasles
