#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace chasles {

/// Reusable storage for temporary matrices of varying size. It only grows, so that heap allocations
/// cease after some time. Copying a Scratch does not copy its contents.
class Scratch {
 public:
  Scratch() = default;
  Scratch(const Scratch&) {}
  Scratch& operator=(const Scratch&) { return *this; }
  Scratch(Scratch&&) = default;
  Scratch& operator=(Scratch&&) = default;
  ~Scratch() = default;

  /// An uninitialised matrix; it becomes invalid with the next call.
  template <class Matrix = Eigen::MatrixXd>
  Eigen::Map<Matrix, Eigen::AlignedMax> take(Eigen::Index rows, Eigen::Index cols = 1) {
    const Eigen::Index size = rows * cols;
    if (size > storage_.size()) storage_.resize(std::max(size, 2 * storage_.size()));
    return {storage_.data(), rows, cols};
  }

 private:
  Eigen::VectorXd storage_;
};

/// A list that keeps removed elements, with their heap memory, for reuse by later ones. A new
/// element is therefore not empty; the caller must overwrite it.
template <class T>
class Reused {
 public:
  T* begin() { return items_.data(); }
  T* end() { return items_.data() + size_; }
  const T* begin() const { return items_.data(); }
  const T* end() const { return items_.data() + size_; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  T& operator[](std::size_t i) { return items_[i]; }
  const T& operator[](std::size_t i) const { return items_[i]; }

  T& append() {
    if (size_ == items_.size()) items_.emplace_back();
    return items_[size_++];
  }
  /// Inserts an element before `place`.
  T& insert(const T* place) {
    const auto at = place - begin();
    append();
    std::rotate(begin() + at, end() - 1, end());
    return items_[static_cast<std::size_t>(at)];
  }
  void remove_last() { --size_; }
  void clear() { size_ = 0; }
  /// Removes all matching elements; the others keep their order.
  template <class Predicate>
  void remove_if(const Predicate& goes) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < size_; ++i) {
      if (goes(std::as_const(items_[i]))) continue;
      if (kept != i) std::swap(items_[kept], items_[i]);
      ++kept;
    }
    size_ = kept;
  }

 private:
  std::vector<T> items_;
  std::size_t size_ = 0;
};

/// Workspace for the algebra of an update (whitening.hpp).
struct WhiteningScratch {
  Scratch core, clones, transposed;  ///< a Jacobian's columns of the core and of clones
  Scratch gathered;                  ///< factor of the clones' columns
  std::vector<int> clone_rows;       ///< the first row of each block of six, rising
  Scratch S, HW;
  Scratch residual, information;  ///< of compressed measurements
  std::vector<int> order;         ///< of the pivots
  Scratch W, kept, w;             ///< the result
};

}  // namespace chasles
