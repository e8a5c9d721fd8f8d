#include <algorithm>

#include <Eigen/Cholesky>

#include <chasles/filter/dense.hpp>
#include <chasles/smooth/window/window_inner_detail.hpp>

namespace chasles::smooth_detail {

InnerStates::InnerStates(const Window& window, const WindowRows& rows)
    : rows_(rows), errors_(rows.errors - kPoseErrors), count_(std::max(rows.keyframes - 1, 0)) {
  if (errors_ == 0) count_ = 0;
  const int all = errors_ * count_;
  own_.setZero(errors_, all);
  older_.setZero(errors_, all);
  outer_.setZero(rows.size, all);
  g_.setZero(all);
  newest_ = window.last();
}

void InnerStates::add_prior(const WindowSystem& prior, const WindowRows& from) {
  if (count_ == 0 || from.keyframes == 0) return;
  const int begin = from.keyframe(from.first) + kPoseErrors, end = begin + errors_;
  own(rows_.first) += prior.S.block(begin, begin, errors_, errors_);
  g(rows_.first) += prior.g.segment(begin, errors_);
  // Landmarks, calibration and the pose are before these rows of the prior, other poses behind.
  auto outer = this->outer(rows_.first);
  for (const auto& [number, row] : from.points) {
    outer.middleRows(rows_.points.at(number), 3) +=
        prior.S.block(begin, row, errors_, 3).transpose();
  }
  outer.middleRows(rows_.calibration, from.calibration_errors) +=
      prior.S.block(begin, from.calibration, errors_, from.calibration_errors).transpose();
  outer.middleRows(rows_.keyframe(rows_.first), kPoseErrors) +=
      prior.S.block(begin, begin - kPoseErrors, errors_, kPoseErrors).transpose();
  const Eigen::Index others = prior.S.rows() - end;
  outer.middleRows(rows_.keyframe(rows_.first + 1), others) +=
      prior.S.block(end, begin, others, errors_);
}

void InnerStates::add(const ChainTerm& term, WindowSystem& system) {
  const int n = rows_.errors * term.keyframes, end = term.first + term.keyframes;
  const auto J = term.jacobian.leftCols(n);
  const Eigen::MatrixXd H = J.transpose() * J;
  const Eigen::VectorXd g = J.transpose() * term.residual;
  const auto outside = [&](int keyframe) {
    return is_inner(keyframe) ? kPoseErrors : rows_.errors;
  };
  for (int k = term.first; k < end; ++k) {
    const int i = rows_.errors * (k - term.first), row = rows_.keyframe(k), width = outside(k);
    system.g.segment(row, width) += g.segment(i, width);
    for (int later = k; later < end; ++later) {
      const int j = rows_.errors * (later - term.first);
      system.S.block(rows_.keyframe(later), row, outside(later), width) +=
          H.block(j, i, outside(later), width);
    }
    if (!is_inner(k)) continue;
    const int inner = i + kPoseErrors;
    own(k) += H.block(inner, inner, errors_, errors_);
    this->g(k) += g.segment(inner, errors_);
    for (int other = term.first; other < end; ++other) {
      const int j = rows_.errors * (other - term.first);
      outer(k).middleRows(rows_.keyframe(other), outside(other)) +=
          H.block(j, inner, outside(other), errors_);
    }
    if (k > term.first) older(k) += H.block(inner - rows_.errors, inner, errors_, errors_);
  }
  if (term.calibration) add_calibration(term, system);
}

void InnerStates::add_calibration(const ChainTerm& term, WindowSystem& system) {
  const int c = rows_.calibration + term.calibration->row, m = term.calibration->errors;
  const auto K = term.jacobian.rightCols(m);
  system.S.block(c, c, m, m).noalias() += K.transpose() * K;
  system.g.segment(c, m).noalias() += K.transpose() * term.residual;
  for (int i = 0; i < term.keyframes; ++i) {
    const int k = term.first + i, width = is_inner(k) ? kPoseErrors : rows_.errors;
    const auto J = term.jacobian.middleCols(rows_.errors * i, rows_.errors);
    system.S.block(rows_.keyframe(k), c, width, m).noalias() += J.leftCols(width).transpose() * K;
    if (is_inner(k)) outer(k).middleRows(c, m).noalias() += K.transpose() * J.rightCols(errors_);
  }
}

void InnerStates::damp(double damping) {
  for (int i = 0; i < count_; ++i) own(rows_.first + i).diagonal() *= 1 + damping;
}

bool InnerStates::eliminate(WindowSystem& system) {
  for (int i = count_ - 1; i >= 0; --i) {
    const int k = rows_.first + i;
    const Eigen::LLT<Eigen::MatrixXd> cholesky(own(k));
    if (cholesky.info() != Eigen::Success) return false;
    // From here on `own` is L^-1, and all others are multiplied by it or L^-T.
    own(k) = cholesky.matrixL().solve(Eigen::MatrixXd::Identity(errors_, errors_));
    const Eigen::MatrixXd inverse = own(k).transpose();
    const int begin = first_row(k), count = rows_.size - begin;
    auto outer = this->outer(k).bottomRows(count);
    outer = (outer * inverse).eval();
    g(k) = (inverse.transpose() * g(k)).eval();
    system.g.tail(count).noalias() -= outer * g(k);
    dense::downdate_lower(outer, system.S.bottomRightCorner(count, count));
    if (i == 0) continue;
    older(k) = (older(k) * inverse).eval();
    own(k - 1).noalias() -= older(k) * older(k).transpose();
    g(k - 1).noalias() -= older(k) * g(k);
    this->outer(k - 1).bottomRows(count).noalias() -= outer * older(k).transpose();
  }
  return true;
}

Eigen::VectorXd InnerStates::with_inner(const Eigen::VectorXd& x, const WindowRows& all) const {
  Eigen::VectorXd whole(all.size);
  whole.head(all.begin) = x.head(rows_.begin);
  for (int k = rows_.first; k <= newest_; ++k) {
    const int row = all.keyframe(k), width = is_inner(k) ? kPoseErrors : rows_.errors;
    whole.segment(row, width) = x.segment(rows_.keyframe(k), width);
    if (!is_inner(k)) continue;
    const int begin = first_row(k), count = rows_.size - begin;
    Eigen::VectorXd right = -g(k);
    right.noalias() -= outer(k).bottomRows(count).transpose() * x.tail(count);
    if (k > rows_.first) {
      right.noalias() -= older(k).transpose() * whole.segment(row - errors_, errors_);
    }
    whole.segment(row + kPoseErrors, errors_).noalias() = own(k).transpose() * right;
  }
  return whole;
}

InnerStates::Reduced InnerStates::reduced(const Eigen::VectorXd& gradient,
                                          const WindowRows& all) const {
  Reduced result{.g = in_rows(gradient, all, rows_)};
  Eigen::VectorXd carried = Eigen::VectorXd::Zero(errors_);
  for (int k = rows_.first + count_ - 1; k >= rows_.first; --k) {
    const Eigen::VectorXd y =
        own(k) * (gradient.segment(all.keyframe(k) + kPoseErrors, errors_) - carried);
    result.decrease += y.squaredNorm() / 2;
    const int count = rows_.size - first_row(k);
    result.g.tail(count).noalias() -= outer(k).bottomRows(count) * y;
    carried.noalias() = older(k) * y;
  }
  return result;
}

}  // namespace chasles::smooth_detail
