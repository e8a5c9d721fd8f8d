#pragma once

#include <Eigen/Core>

#include <chasles/smooth/window/window_detail.hpp>

namespace chasles::smooth_detail {

/// The inner errors of a window's keyframes: those besides the pose, of all keyframes but the
/// newest. Only terms of neighbours couple them, and the prior those of the oldest, so they are
/// eliminated before the dense system of the other rows (WindowRows::outer) is factorised. The
/// order is from the newest to the oldest: until the last one, only later poses are filled in.
class InnerStates {
 public:
  /// `rows`: WindowRows::outer.
  InnerStates(const Window& window, const WindowRows& rows);

  /// The prior's system, of its rows; only what it says about inner errors.
  void add_prior(const WindowSystem& prior, const WindowRows& from);
  /// Adds a term to its rows of the system, and to these.
  void add(const ChainTerm& term, WindowSystem& system);
  /// Enlarges the diagonal by this fraction.
  void damp(double damping);
  /// Subtracts the Schur complement from the system; lower triangle. False: not positive definite.
  bool eliminate(WindowSystem& system);
  /// The solution in the rows of all errors, from that of the outer ones.
  Eigen::VectorXd with_inner(const Eigen::VectorXd& x, const WindowRows& all) const;
  /// Half of the decrease along the inner errors that a gradient in the rows of all errors
  /// predicts, and what remains of it for the outer rows.
  struct Reduced {
    double decrease = 0;
    Eigen::VectorXd g;
  };
  Reduced reduced(const Eigen::VectorXd& gradient, const WindowRows& all) const;

 private:
  bool is_inner(int keyframe) const { return errors_ > 0 && keyframe != newest_; }
  int column(int keyframe) const { return errors_ * (keyframe - rows_.first); }
  auto own(int keyframe) { return own_.middleCols(column(keyframe), errors_); }
  auto own(int keyframe) const { return own_.middleCols(column(keyframe), errors_); }
  auto older(int keyframe) { return older_.middleCols(column(keyframe), errors_); }
  auto older(int keyframe) const { return older_.middleCols(column(keyframe), errors_); }
  auto outer(int keyframe) { return outer_.middleCols(column(keyframe), errors_); }
  auto outer(int keyframe) const { return outer_.middleCols(column(keyframe), errors_); }
  auto g(int keyframe) { return g_.segment(column(keyframe), errors_); }
  auto g(int keyframe) const { return g_.segment(column(keyframe), errors_); }
  void add_calibration(const ChainTerm& term, WindowSystem& system);
  /// The first row that a keyframe's inner errors fill when they are eliminated.
  int first_row(int keyframe) const {
    if (keyframe == rows_.first) return 0;
    return rows_.calibration_errors > 0 ? rows_.calibration : rows_.keyframe(keyframe - 1);
  }

  WindowRows rows_;
  int errors_, count_, newest_;
  Eigen::MatrixXd own_;    // blocks of the diagonal; later the inverse factors
  Eigen::MatrixXd older_;  // rows of the keyframe before, columns of this one
  Eigen::MatrixXd outer_;  // rows of the system
  Eigen::VectorXd g_;
};

}  // namespace chasles::smooth_detail
