#include "frame_work.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace chasles::bench {
namespace {

int fresh_rows(const FrameStep& step) {
  Eigen::Index k = 0;
  for (const Fresh& f : step.fresh) k += f.d_pose.rows();
  return static_cast<int>(k);
}

template <typename S>
void set_fresh(const FrameStep& step, bool newest_first, Work<S>& w) {
  const Eigen::Index k = fresh_rows(step);
  Eigen::MatrixXd d_pose(k, 6);
  Eigen::MatrixXd noise = Eigen::MatrixXd::Zero(k, k);
  Eigen::MatrixXd noise_root = noise;
  Eigen::Index at = 0;
  for (const Fresh& f : step.fresh) {
    const Eigen::Index size = f.d_pose.rows();
    d_pose.middleRows(at, size) = f.d_pose;
    noise.block(at, at, size, size) = f.noise;
    noise_root.block(at, at, size, size) = root(f.noise);
    at += size;
  }
  if (newest_first) {
    d_pose = d_pose.colwise().reverse().eval();
    noise.reverseInPlace();
    noise_root = noise_root.rowwise().reverse().eval();
  }
  w.d_pose = d_pose.cast<S>();
  w.noise = noise.cast<S>();
  w.noise_root = noise_root.cast<S>();
}

template <typename S>
void set_rows(const FrameStep& step, int size, bool newest_first, Work<S>& w) {
  const Eigen::Index core = step.prediction.F.rows();
  Eigen::Index m = 0;
  for (const Measurement& z : step.used) m += z.residual.size();
  w.H_core = MatrixOf<S>::Zero(m, core);
  w.residual.resize(m);
  Eigen::Index at = 0;
  const auto place = [&](int row, const Eigen::MatrixXd& d) {
    const auto width = static_cast<int>(d.cols());
    if (newest_first) {
      const Eigen::MatrixXd reversed = d.rowwise().reverse();
      w.H_parts.push_back({.at = at, .row = core + size - row - width, .d = reversed.cast<S>()});
    } else {
      w.H_parts.push_back({.at = at, .row = row, .d = d.cast<S>()});
    }
  };
  for (const Measurement& z : step.used) {
    const Eigen::Index rows = z.residual.size();
    const double sigma = std::sqrt(z.noise(0, 0));
    w.H_core.block(at, z.core_column, rows, z.d_core.cols()) = (z.d_core / sigma).cast<S>();
    w.residual.segment(at, rows) = (z.residual / sigma).cast<S>();
    if (z.landmark >= 0) {
      place(step.state.landmarks[static_cast<std::size_t>(z.landmark)].row, z.d_landmark / sigma);
    }
    for (const auto& clone : z.clones) place(clone.row, clone.d / sigma);
    at += rows;
  }
}

}  // namespace

Eigen::MatrixXd root(const Eigen::MatrixXd& A) {
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(A);
  const Eigen::VectorXd d = ldlt.vectorD().cwiseMax(0).cwiseSqrt();
  Eigen::MatrixXd G = Eigen::MatrixXd::Identity(A.rows(), A.cols());
  G = (ldlt.transpositionsP() * G).eval();
  G = (ldlt.matrixU() * G).eval();
  return d.asDiagonal() * G;
}

template <typename S>
Work<S> work_of(const FrameStep& step, int size_before, bool newest_first) {
  Work<S> w;
  w.F = step.prediction.F.cast<S>();
  w.Q = step.prediction.Q.cast<S>();
  w.G = root(step.prediction.Q).cast<S>();
  const auto core = static_cast<int>(step.prediction.F.rows());
  w.keep = step.keep;
  if (newest_first) {
    std::reverse(w.keep.begin() + core, w.keep.end());
    for (auto row = w.keep.begin() + core; row != w.keep.end(); ++row) {
      *row = core + size_before - 1 - *row;
    }
  }
  set_fresh(step, newest_first, w);
  const int size = static_cast<int>(w.keep.size()) + fresh_rows(step);
  set_rows(step, size, newest_first, w);
  return w;
}

template Work<float> work_of<float>(const FrameStep&, int, bool);
template Work<double> work_of<double>(const FrameStep&, int, bool);

}  // namespace chasles::bench
