#pragma once

#include <vector>

#include <Eigen/Core>

namespace chasles {

/// A symmetric matrix (a covariance, or the information that is its counterpart) with room to grow
/// in place: rows come and go without moving the storage until the room runs out, when it doubles.
/// Both triangles are kept.
class Covariance {
 public:
  using Block = Eigen::Block<Eigen::MatrixXd>;
  using ConstBlock = const Eigen::Block<const Eigen::MatrixXd>;

  explicit Covariance(const Eigen::MatrixXd& initial);

  int size() const { return size_; }
  Block all() { return storage_.topLeftCorner(size_, size_); }
  ConstBlock all() const { return storage_.topLeftCorner(size_, size_); }

  /// Appends rows of zeros; returns the first of them.
  int append(int rows);

  /// Keeps these rows, which must rise, in this order, and drops the others.
  void keep(const std::vector<int>& rows);

  /// Drops all rows from `size` on.
  void truncate(int size) { size_ = size; }

  /// The reverse of keep: grows to `size`, with row i now at rows[i], which must rise, and zeros
  /// elsewhere.
  void spread(const std::vector<int>& rows, int size);

 private:
  /// Neighbours that stay neighbours: size rows from `dense` on are, in the larger matrix, at
  /// `sparse`.
  struct Run {
    int dense, sparse, size;
  };

  void make_room(int size);
  void find_runs(const std::vector<int>& rows);

  Eigen::MatrixXd storage_;
  int size_ = 0;
  std::vector<Run> runs_;  ///< of the call that is at work
};

}  // namespace chasles
