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

void Covariance::make_room(int size) {
  if (size <= storage_.rows()) return;
  const Eigen::Index room = std::max<Eigen::Index>(2 * storage_.rows(), size);
  Eigen::MatrixXd larger(room, room);
  larger.topLeftCorner(size_, size_) = all();
  storage_.swap(larger);
}

int Covariance::append(int rows) {
  const int first = size_;
  make_room(size_ + rows);
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

void Covariance::spread(const std::vector<int>& rows, int size) {
  make_room(size);
  const int n = size_;
  // Backwards, so that every number moves away from the origin before its place is taken.
  for (int j = n - 1; j >= 0; --j) {
    const double* source = storage_.col(j).data();
    double* target = storage_.col(rows[j]).data();
    int end = size;
    for (int i = n - 1; i >= 0; --i) {
      const double value = source[i];
      std::fill(target + rows[i] + 1, target + end, 0.0);
      target[rows[i]] = value;
      end = rows[i];
    }
    std::fill(target, target + end, 0.0);
  }
  int next = 0;
  for (int j = 0; j < size; ++j) {
    if (next < n && rows[next] == j) {
      ++next;
    } else {
      storage_.col(j).head(size).setZero();
    }
  }
  size_ = size;
}

}  // namespace chasles
