#pragma once

#include <algorithm>
#include <vector>

#include <Eigen/Core>

namespace chasles {

/// Storage for numbers that are needed for a moment, again and again, in sizes that vary. It only
/// grows: after a while the heap is not asked any more. Of its contents nothing is copied.
class Scratch {
 public:
  Scratch() = default;
  Scratch(const Scratch&) {}
  Scratch& operator=(const Scratch&) { return *this; }
  Scratch(Scratch&&) = default;
  Scratch& operator=(Scratch&&) = default;
  ~Scratch() = default;

  /// A matrix whose coefficients are yet to be written; it ends with the next call.
  template <class Matrix = Eigen::MatrixXd>
  Eigen::Map<Matrix, Eigen::AlignedMax> take(Eigen::Index rows, Eigen::Index cols = 1) {
    const Eigen::Index size = rows * cols;
    if (size > storage_.size()) storage_.resize(std::max(size, 2 * storage_.size()));
    return {storage_.data(), rows, cols};
  }

 private:
  Eigen::VectorXd storage_;
};

/// What the algebra of an update writes on the way (whitening.hpp).
struct WhiteningScratch {
  Scratch core, clones, transposed;  ///< a Jacobian's columns of the core and of clones
  Scratch gathered;                  ///< what those of the clones are multiplied with
  std::vector<int> clone_rows;       ///< the first of each six, rising
  Scratch S, HW, HW_transposed;
  Scratch W, w;  ///< the result
};

}  // namespace chasles
