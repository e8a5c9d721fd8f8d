#include <algorithm>
#include <chasles/filter/covariance.hpp>

namespace chasles {
namespace {

// Room for pose, velocities, biases and 80 landmarks in view: enough for most recordings.
constexpr int kInitialRoom = 256;

}  // namespace

Covariance::Covariance(const Eigen::MatrixXd& initial) : size_(static_cast<int>(initial.rows())) {
  const int room = std::max(kInitialRoom, size_);
  storage_.setZero(room, room);
  all() = initial;
}

int Covariance::append(int rows) {
  const int first = size_;
  if (size_ + rows > storage_.rows()) {
    const Eigen::Index room = std::max<Eigen::Index>(2 * storage_.rows(), size_ + rows);
    Eigen::MatrixXd larger(room, room);
    larger.topLeftCorner(size_, size_) = all();
    storage_.swap(larger);
  }
  size_ += rows;
  storage_.block(first, 0, rows, size_).setZero();
  storage_.block(0, first, first, rows).setZero();
  return first;
}

void Covariance::keep(const std::vector<int>& rows) {
  const int n = static_cast<int>(rows.size());
  // Rows rise, so every number moves towards the origin and none is overwritten before it is read.
  for (int j = 0; j < n; ++j) {
    const double* source = storage_.col(rows[j]).data();
    double* target = storage_.col(j).data();
    for (int i = 0; i < n; ++i) target[i] = source[rows[i]];
  }
  size_ = n;
}

}  // namespace chasles
