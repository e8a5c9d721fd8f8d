#include "textbook.hpp"

#include <random>

#include <Eigen/LU>

namespace chasles::bench {
namespace {

Eigen::MatrixXd random_matrix(std::mt19937_64& random, Eigen::Index rows, Eigen::Index cols) {
  return Eigen::MatrixXd::NullaryExpr(
      rows, cols, [&] { return static_cast<double>(random() >> 11) * 0x1p-52 - 1; });
}

}  // namespace

Walk random_walk() {
  std::mt19937_64 random(1);
  const auto square = [&](Eigen::Index n) {
    const Eigen::MatrixXd A = random_matrix(random, n, n);
    return Eigen::MatrixXd(A * A.transpose());
  };
  Walk walk{.core_covariance = square(15), .frames = {}};
  State x;
  LandmarkId id = 0;
  x.v_world = Eigen::Vector3d::Zero();
  x.additive = Eigen::VectorXd::Zero(6);
  for (int frame = 0; frame < 8; ++frame) {
    FrameStep step;
    step.prediction = {.world_T_imu = {},
                       .v_world = x.v_world,
                       .additive = x.additive,
                       .F = Eigen::MatrixXd::Identity(15, 15) + 0.3 * random_matrix(random, 15, 15),
                       .Q = square(15)};
    std::vector<Landmark> kept;
    int row = 15;
    for (int i = 0; i < 15; ++i) step.keep.push_back(i);
    for (std::size_t i = 0; i < x.landmarks.size(); ++i) {
      if (i % 5 == static_cast<std::size_t>(frame) % 5) {
        step.retired.push_back(static_cast<int>(i));
        continue;
      }
      for (int k = 0; k < 3; ++k) step.keep.push_back(x.landmarks[i].row + k);
      kept.push_back(x.landmarks[i]);
      kept.back().row = row;
      row += 3;
    }
    x.landmarks = kept;
    for (int i = 0; i < 9; ++i, row += 3) {
      x.landmarks.push_back({.id = id, .row = row});
      step.fresh.push_back({.id = id++, .d_pose = random_matrix(random, 3, 6), .noise = square(3)});
    }
    for (std::size_t i = 0; i < x.landmarks.size(); ++i) {
      Measurement z;
      z.landmark = static_cast<int>(i);
      z.residual = random_matrix(random, 2, 1);
      z.d_core = random_matrix(random, 2, 6);
      z.d_landmark = random_matrix(random, 2, 3);
      z.noise = 0.25 * Eigen::Matrix2d::Identity();
      if (i > 2) {  // an anchored landmark: three rows of the state replaced by a clone's six
        z.clones.push_back({.row = x.landmarks[i - 2].row, .d = random_matrix(random, 2, 6)});
      }
      step.used.push_back(z);
    }
    step.state = x;
    walk.frames.push_back(step);
  }
  return walk;
}

std::pair<Oracle, Oracle> textbook(const Walk& walk) {
  Oracle P = walk.core_covariance.cast<long double>();
  Oracle correction;
  for (const FrameStep& step : walk.frames) {
    const Oracle F = step.prediction.F.cast<long double>();
    Oracle full = Oracle::Identity(P.rows(), P.rows());
    full.topLeftCorner(15, 15) = F;
    P = (full * P * full.transpose()).eval();
    P.topLeftCorner(15, 15) += step.prediction.Q.cast<long double>();
    P = Oracle(P(step.keep, step.keep));
    for (const Fresh& fresh : step.fresh) {
      Oracle J = Oracle::Identity(P.rows() + 3, P.rows());
      J.bottomRows(3).setZero();
      J.bottomLeftCorner(3, 6) = fresh.d_pose.cast<long double>();
      P = (J * P * J.transpose()).eval();
      P.bottomRightCorner(3, 3) += fresh.noise.cast<long double>();
    }
    const auto m = 2 * static_cast<Eigen::Index>(step.used.size());
    Oracle H = Oracle::Zero(m, P.rows());
    Oracle r(m, 1);
    for (Eigen::Index i = 0; i < m / 2; ++i) {
      const Measurement& z = step.used[static_cast<std::size_t>(i)];
      const auto& l = step.state.landmarks[static_cast<std::size_t>(z.landmark)];
      H.block(2 * i, 0, 2, 6) += z.d_core.cast<long double>();
      H.block(2 * i, l.row, 2, 3) += z.d_landmark.cast<long double>();
      for (const auto& clone : z.clones) {
        H.block(2 * i, clone.row, 2, 6) += clone.d.cast<long double>();
      }
      r.middleRows(2 * i, 2) = z.residual.cast<long double>();
    }
    const Oracle S = H * P * H.transpose() + Oracle::Identity(m, m) * 0.25L;
    const Oracle K = P * H.transpose() * S.inverse();
    correction = K * r;
    P = (P - K * H * P).eval();
    P = ((P + P.transpose()) / 2).eval();
  }
  return {P, correction};
}

}  // namespace chasles::bench
