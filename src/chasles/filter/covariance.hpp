#pragma once

#include <vector>

#include <Eigen/Core>

namespace chasles {

/// A symmetric matrix (a covariance or an information matrix) that can grow in place. Rows are
/// added and removed without reallocation until the capacity is exhausted; then it doubles. Both
/// triangles are stored.
class Covariance {
 public:
  using Block = Eigen::Block<Eigen::MatrixXd>;
  using ConstBlock = const Eigen::Block<const Eigen::MatrixXd>;

  explicit Covariance(const Eigen::MatrixXd& initial);

  int size() const { return size_; }
  Block all() { return storage_.topLeftCorner(size_, size_); }
  ConstBlock all() const { return storage_.topLeftCorner(size_, size_); }

  /// Appends rows (and columns) of zeros; returns the index of the first.
  int append(int rows);

  /// Keeps these rows and removes the others. The indices must rise.
  void keep(const std::vector<int>& rows);

  /// Removes all rows from `size` on.
  void truncate(int size) { size_ = size; }

  /// The reverse of keep: grows to `size` and moves row i to rows[i], with zeros elsewhere. The
  /// indices must rise.
  void spread(const std::vector<int>& rows, int size);

 private:
  /// Contiguous rows that stay contiguous: `size` rows from `dense` on are at `sparse` in the
  /// larger matrix.
  struct Run {
    int dense, sparse, size;
  };

  void make_room(int size);
  void find_runs(const std::vector<int>& rows);

  Eigen::MatrixXd storage_;
  int size_ = 0;
  std::vector<Run> runs_;  ///< of the current call
};

}  // namespace chasles
