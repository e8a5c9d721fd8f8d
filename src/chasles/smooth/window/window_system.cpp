#include <algorithm>
#include <cassert>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <chasles/smooth/window/window_inner_detail.hpp>

// The quadratic form of a window: prior, terms, and landmarks by their Schur complements.
namespace chasles::smooth_detail {
namespace {

// Limits for the eigenvalues of V, relative to the largest: directions below the first are
// undetermined. If Cholesky's pivots are above the second, all are determined.
constexpr double kUndetermined = 1e-12, kCertainlyDetermined = 1e-8;

// The lower triangle of the block at rows i and columns j, the first rows of two poses.
void add_block(int i, int j, const Matrix6d& block, Eigen::MatrixXd& S) {
  if (i >= j) {
    S.block<6, 6>(i, j) += block;
  } else {
    S.block<6, 6>(j, i) += block.transpose();
  }
}

void add_pose_blocks(const WindowRows& rows, const PointLinear& linear, WindowSystem& system) {
  const int c = rows.calibration, n = rows.calibration_errors;
  if (n > 0) {
    system.S.block(c, c, n, n) += linear.calibration.H;
    system.g.segment(c, n) += linear.calibration.g;
    for (std::size_t k = 0; k < linear.calibration.by_pose.size(); ++k) {
      const int i = rows.keyframe(linear.pose_blocks[k].keyframe);
      system.S.block(i, c, 6, n) += linear.calibration.by_pose[k];
    }
  }
  for (const PointLinear::PoseBlock& pose_block : linear.pose_blocks) {
    const int i = rows.keyframe(pose_block.keyframe);
    system.S.block<6, 6>(i, i) += pose_block.H;
    system.g.segment<6>(i) += pose_block.g;
    if (&pose_block == &linear.pose_blocks.front()) continue;
    const int a = rows.keyframe(linear.pose_blocks.front().keyframe);
    add_block(i, a, pose_block.by_anchor, system.S);
  }
}

// The pose blocks by their rows, which for an anchor that is not the first may be out of order.
std::vector<const PointLinear::PoseBlock*> in_order(const PointLinear& linear) {
  std::vector<const PointLinear::PoseBlock*> blocks;
  blocks.reserve(linear.pose_blocks.size());
  for (const PointLinear::PoseBlock& block : linear.pose_blocks) blocks.push_back(&block);
  std::ranges::sort(blocks, {}, &PointLinear::PoseBlock::keyframe);
  return blocks;
}

void eliminate(const WindowRows& rows, const PointLinear& linear, const Eigen::Matrix3d& V_inverse,
               WindowSystem& system) {
  const int c = rows.calibration, n = rows.calibration_errors;
  if (n > 0) {
    const Eigen::Matrix<double, Eigen::Dynamic, 3> Y = linear.calibration.W * V_inverse;
    system.g.segment(c, n).noalias() -= Y * linear.b;
    system.S.block(c, c, n, n).noalias() -= Y * linear.calibration.W.transpose();
  }
  const auto blocks = in_order(linear);
  Eigen::Matrix<double, Eigen::Dynamic, 3> Y(kPoseErrors * std::ssize(blocks), 3);
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    Y.middleRows<6>(6 * static_cast<Eigen::Index>(k)).noalias() = blocks[k]->W * V_inverse;
  }
  // Poses with rows in a row are subtracted together.
  for (std::size_t k = 0; k < blocks.size();) {
    const int i = rows.keyframe(blocks[k]->keyframe);
    std::size_t end = k + 1;
    while (end < blocks.size() &&
           rows.keyframe(blocks[end]->keyframe) == i + kPoseErrors * static_cast<int>(end - k)) {
      ++end;
    }
    const auto first = 6 * static_cast<Eigen::Index>(k), last = 6 * static_cast<Eigen::Index>(end);
    const auto of = Y.middleRows(first, last - first);
    system.g.segment(i, of.rows()).noalias() -= of.lazyProduct(linear.b);
    if (n > 0) {
      system.S.block(i, c, of.rows(), n).noalias() -= of * linear.calibration.W.transpose();
    }
    for (std::size_t by = 0; by < end; ++by) {
      const int j = rows.keyframe(blocks[by]->keyframe);
      const auto skip = by <= k ? 0 : 6 * static_cast<Eigen::Index>(by - k);
      system.S.block(i + skip, j, of.rows() - skip, 6).noalias() -=
          of.bottomRows(of.rows() - skip).lazyProduct(blocks[by]->W.transpose());
    }
    k = end;
  }
}

}  // namespace

WindowRows::WindowRows(const Window& window, int keyframe_count, int whole_count)
    : errors(window.sizes.errors()),
      first(window.first),
      keyframes(keyframe_count),
      whole(std::min(whole_count, keyframe_count)) {
  for (const auto& [number, point] : window.points) {
    if (!point.in_prior) continue;
    points.emplace(number, begin);
    begin += 3;
  }
  calibration = begin;
  calibration_errors = window.sizes.calibration.errors();
  begin += calibration_errors;
  size = keyframe(first + keyframes);
}

WindowRows WindowRows::outer(const Window& window) {
  WindowRows rows(window, window.count(), 0);
  if (rows.keyframes == 0) return rows;
  rows.newest_whole = true;
  rows.size += rows.errors - kPoseErrors;
  return rows;
}

namespace {

// Rows that both have; blocks that stay adjacent are one run.
struct Run {
  int from, to, count;
};

std::vector<Run> runs_of(const WindowRows& from, const WindowRows& to) {
  std::vector<Run> runs;
  const auto add = [&](const Run& run) {
    const bool joins = !runs.empty() && runs.back().from + runs.back().count == run.from &&
                       runs.back().to + runs.back().count == run.to;
    if (joins) {
      runs.back().count += run.count;
    } else {
      runs.push_back(run);
    }
  };
  for (const auto& [number, row] : from.points) {
    const auto at = to.points.find(number);
    if (at != to.points.end()) add({.from = row, .to = at->second, .count = 3});
  }
  if (from.calibration_errors > 0) {
    add({.from = from.calibration, .to = to.calibration, .count = from.calibration_errors});
  }
  const int end = std::min(from.first + from.keyframes, to.first + to.keyframes);
  for (int k = std::max(from.first, to.first); k < end; ++k) {
    const int count = std::min(from.errors_of(k), to.errors_of(k));
    add({.from = from.keyframe(k), .to = to.keyframe(k), .count = count});
  }
  return runs;
}

}  // namespace

WindowSystem in_rows(const WindowSystem& system, const WindowRows& from, const WindowRows& to) {
  const std::vector<Run> runs = runs_of(from, to);
  WindowSystem moved{.S = Eigen::MatrixXd::Zero(to.size, to.size),
                     .g = in_rows(system.g, from, to)};
  for (auto i = runs.begin(); i != runs.end(); ++i) {
    for (auto j = runs.begin(); j <= i; ++j) {
      moved.S.block(i->to, j->to, i->count, j->count) =
          system.S.block(i->from, j->from, i->count, j->count);
    }
  }
  return moved;
}

Eigen::VectorXd in_rows(const Eigen::VectorXd& g, const WindowRows& from, const WindowRows& to) {
  Eigen::VectorXd moved = Eigen::VectorXd::Zero(to.size);
  for (const Run& run : runs_of(from, to)) {
    moved.segment(run.to, run.count) = g.segment(run.from, run.count);
  }
  return moved;
}

Eigen::Matrix3d PointLinear::damped_inverse(double damping) const {
  if (damping == 0) return V_inverse;
  Eigen::Matrix3d damped = V;
  damped.diagonal() *= 1 + damping;
  return inverse_on_range(damped);
}

Eigen::Matrix3d inverse_on_range(const Eigen::Matrix3d& V) {
  const Eigen::LLT<Eigen::Matrix3d> cholesky(V);
  const double least = cholesky.matrixLLT().diagonal().cwiseAbs2().minCoeff();
  if (cholesky.info() == Eigen::Success && least > kCertainlyDetermined * V.diagonal().maxCoeff()) {
    return cholesky.solve(Eigen::Matrix3d::Identity());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(V);
  const Eigen::Vector3d& information = eigen.eigenvalues();
  Eigen::Vector3d inverse = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    if (information[i] > kUndetermined * information[2]) inverse[i] = 1 / information[i];
  }
  return eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
}

void add_point(const WindowRows& rows, const PointLinear& linear, std::optional<int> row,
               const Eigen::Matrix3d& V_inverse, WindowSystem& system) {
  add_pose_blocks(rows, linear, system);
  if (!row) {
    eliminate(rows, linear, V_inverse, system);
    return;
  }
  system.S.block<3, 3>(*row, *row) += linear.V;
  system.g.segment<3>(*row) += linear.b;
  if (rows.calibration_errors > 0) {
    system.S.block(rows.calibration, *row, rows.calibration_errors, 3) += linear.calibration.W;
  }
  for (const PointLinear::PoseBlock& pose_block : linear.pose_blocks) {
    system.S.block<6, 3>(rows.keyframe(pose_block.keyframe), *row) += pose_block.W;
  }
}

void add_term(const WindowRows& rows, const ChainTerm& term, WindowSystem& system) {
  assert(term.first + term.keyframes <= rows.first + rows.whole);
  const int row = rows.keyframe(term.first);
  const int n = rows.errors * term.keyframes;
  const auto J = term.jacobian.leftCols(n);
  system.S.block(row, row, n, n).noalias() += J.transpose() * J;
  system.g.segment(row, n).noalias() += J.transpose() * term.residual;
  if (!term.calibration) return;
  const int c = rows.calibration + term.calibration->row, m = term.calibration->errors;
  const auto K = term.jacobian.rightCols(m);
  system.S.block(c, c, m, m).noalias() += K.transpose() * K;
  system.S.block(row, c, n, m).noalias() += J.transpose() * K;
  system.g.segment(c, m).noalias() += K.transpose() * term.residual;
}

Eigen::VectorXd gradient(const Window& window, const WindowRows& rows) {
  Eigen::VectorXd g = in_rows(prior_gradient(window), prior_rows(window), rows);
  for (const ChainTerm& term : window.terms) {
    const int n = rows.errors * term.keyframes;
    g.segment(rows.keyframe(term.first), n).noalias() +=
        term.jacobian.leftCols(n).transpose() * term.residual;
    if (!term.calibration) continue;
    const int m = term.calibration->errors;
    g.segment(rows.calibration + term.calibration->row, m).noalias() +=
        term.jacobian.rightCols(m).transpose() * term.residual;
  }
  for (const auto& [number, point] : window.points) {
    const PointLinear& linear = point.linear;
    Eigen::Vector3d eliminated = Eigen::Vector3d::Zero();
    if (point.in_prior) {
      g.segment<3>(rows.points.at(number)) += linear.b;
    } else {
      eliminated = linear.V_inverse * linear.b;
    }
    if (rows.calibration_errors > 0) {
      g.segment(rows.calibration, rows.calibration_errors) +=
          linear.calibration.g - linear.calibration.W * eliminated;
    }
    for (const PointLinear::PoseBlock& of : linear.pose_blocks) {
      g.segment<6>(rows.keyframe(of.keyframe)) += of.g - of.W * eliminated;
    }
  }
  return g;
}

WindowSystem normal_equations(const Window& window, const WindowRows& rows, double damping,
                              InnerStates& inner) {
  const WindowSystem prior = prior_system(window);
  const WindowRows of_prior = prior_rows(window);
  WindowSystem system = in_rows(prior, of_prior, rows);
  inner.add_prior(prior, of_prior);
  for (const ChainTerm& term : window.terms) inner.add(term, system);
  inner.damp(damping);
  Eigen::VectorXd enlarged = system.S.diagonal();
  for (const auto& [number, point] : window.points) {
    const auto row = rows.points.find(number);
    const bool own = row != rows.points.end();
    add_point(rows, point.linear, own ? std::optional(row->second) : std::nullopt,
              point.linear.damped_inverse(damping), system);
    for (const PointLinear::PoseBlock& pose_block : point.linear.pose_blocks) {
      enlarged.segment<6>(rows.keyframe(pose_block.keyframe)) += pose_block.H.diagonal();
    }
    if (own) enlarged.segment<3>(row->second) += point.linear.V.diagonal();
    if (rows.calibration_errors > 0) {
      enlarged.segment(rows.calibration, rows.calibration_errors) +=
          point.linear.calibration.H.diagonal();
    }
  }
  system.S.diagonal() += damping * enlarged;
  return system;
}

}  // namespace chasles::smooth_detail
