#pragma once

#include <vector>

#include <Eigen/Core>

#include <chasles/filter/dense.hpp>
#include <chasles/filter/past/segment.hpp>
#include <chasles/filter/whitening.hpp>

namespace chasles {

/// The segment (segment.hpp) of the steps that a filter is making. Every step that changes the
/// errors of the state by a matrix, d+ = M d, changes the cross-covariance with the segment's
/// variables by the same matrix: Z <- Z M^T. Without variables nothing costs anything.
class LatestSegment {
 public:
  /// Begins after an earlier segment: with the n errors of the state as starts.
  void begin(Eigen::Index n);
  /// Without variables, and n errors in the state.
  void clear(Eigen::Index n);

  Eigen::Index variables() const { return q_; }
  Eigen::Index item_rows() const { return q_ - segment_.starts; }
  const std::vector<Segment::Item>& items() const { return segment_.items; }

  /// Cross-covariance of the variables with the errors of the state: variables x rows.
  Eigen::Block<Eigen::MatrixXd> Z() { return Z_.topLeftCorner(q_, n_); }
  Eigen::Block<const Eigen::MatrixXd> Z() const { return Z_.topLeftCorner(q_, n_); }

  /// The state has further errors, uncorrelated so far.
  void append_rows(int count);
  /// The state keeps these errors. The indices must rise.
  void keep_rows(const std::vector<int>& rows);

  /// A past state is a linear function of the errors of the state: its cross-covariance with them,
  /// its own covariance, and Z's product with the function transposed.
  void add_item(Segment::Item item, const Eigen::MatrixXd& with_state, const Eigen::MatrixXd& own,
                const Eigen::MatrixXd& with_variables);
  /// Items become the last rows of the state.
  void make_states(const std::vector<int>& numbers);

  void correct(const Whitened& update);

  Segment segment() const;

 private:
  void make_room(Eigen::Index variables, Eigen::Index rows);

  Segment segment_;  ///< without its matrices
  Eigen::Index q_ = 0, n_ = 0;
  Eigen::MatrixXd Z_, G_;  ///< with room; of G_ the lower triangle
  Eigen::VectorXd g_;
};

}  // namespace chasles
