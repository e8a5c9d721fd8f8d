#include <chasles/filter/considered_map.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/lie/small_matrices.hpp>
#include <chasles/lie/so3.hpp>

// Correction of the mean, and of the covariance for the change of the chart.

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

// P <- A P A^T with A = T(x+)^-1 T(x), on the lower triangle.
void Ekf::change_chart(const State& before) {
  auto P = covariance_.all();
  if (chart_->landmark_block) {
    // A adds B θ to the landmarks' rows: P + B Z^T + Z B^T with Z = P_θ + B P_θθ / 2.
    auto B = work_.B.take(P.rows(), 3);
    B.setZero();
    for (std::size_t i = 0; i < state_.landmarks.size(); ++i) {
      if (state_.landmarks[i].anchor) continue;
      B.middleRows<3>(state_.landmarks[i].row) =
          chart_->landmark_block(before.landmarks[i].p_world) -
          chart_->landmark_block(state_.landmarks[i].p_world);
    }
    const Eigen::Matrix3d P_theta = P.topLeftCorner<3, 3>().selfadjointView<Eigen::Lower>();
    auto Z = work_.Z.take(P.rows(), 3);
    Z = P.leftCols<3>();
    Z.topRows<3>() = P_theta;
    auto half = work_.product.take<Eigen::Matrix<double, Eigen::Dynamic, 3>>(P.rows(), 3);
    half.noalias() = B * (0.5 * P_theta);
    Z += half;
    dense::symmetric_update_lower(B, Z, P);
    past_.turn_landmarks(B);
  }
  change_chart_of_clones(before);
  const int n = state_.motion_size();
  const MotionMatrix after = chart_->motion_block(state_).topLeftCorner(n, n);
  MotionMatrix A = chart_->motion_block(before).topLeftCorner(n, n);
  small::solve(after, A);
  if (A.isIdentity(0)) return;
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
  auto P = covariance_.all();
  for (std::size_t i = 0; i < state_.clones.size(); ++i) {
    const Clone& clone = state_.clones[i];
    const Matrix6d A = solve(pose_block(*chart_, clone.world_T_imu),
                             pose_block(*chart_, before.clones[i].world_T_imu));
    if (A.isIdentity(0)) continue;
    const int r = clone.row;
    const Matrix6d own = P.block<6, 6>(r, r).selfadjointView<Eigen::Lower>();
    P.block<6, 6>(r, r) = A * own * A.transpose();
    auto left = P.block(r, 0, 6, r);
    auto turned = work_.product.take<Eigen::Matrix<double, 6, Eigen::Dynamic>>(6, r);
    turned.noalias() = A * left;
    left = turned;
    auto below = P.block(r + 6, r, P.rows() - r - 6, 6);
    auto turned_below =
        work_.product.take<Eigen::Matrix<double, Eigen::Dynamic, 6>>(below.rows(), 6);
    turned_below.noalias() = below * A.transpose();
    below = turned_below;
    past_.turn_clone(r, A);
  }
}

}  // namespace chasles
