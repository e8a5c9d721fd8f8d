#include <algorithm>
#include <cstring>

#include <chasles/filter/covariance.hpp>

namespace chasles {
namespace {

// Capacity for pose, velocities, biases and 80 landmarks in view: enough for most recordings.
constexpr int kInitialRoom = 256;

// Columns a power of two apart would share a few cache sets. An odd number of cache lines per
// column uses all sets.
Eigen::Index stride(Eigen::Index room) { return 8 * ((room / 8 + 1) | 1); }

}  // namespace

Covariance::Covariance(const Eigen::MatrixXd& initial) : size_(static_cast<int>(initial.rows())) {
  const int room = std::max(kInitialRoom, size_);
  storage_.setZero(stride(room), room);
  all() = initial;
}

void Covariance::find_runs(const std::vector<int>& rows) {
  runs_.clear();
  for (int i = 0; i < static_cast<int>(rows.size()); ++i) {
    const int row = rows[static_cast<std::size_t>(i)];
    if (!runs_.empty() && runs_.back().sparse + runs_.back().size == row) {
      ++runs_.back().size;
    } else {
      runs_.push_back({.dense = i, .sparse = row, .size = 1});
    }
  }
}

void Covariance::make_room(int size) {
  if (size <= storage_.cols()) return;
  const Eigen::Index room = std::max<Eigen::Index>(storage_.cols() + storage_.cols() / 4, size);
  Eigen::MatrixXd larger(stride(room), room);
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
  // Rows rise, so every number moves towards the origin, and none is overwritten before it is read.
  find_runs(rows);
  const int n = static_cast<int>(rows.size());
  for (int j = 0; j < n; ++j) {
    const double* source = storage_.col(rows[static_cast<std::size_t>(j)]).data();
    double* target = storage_.col(j).data();
    for (const Run& run : runs_) {
      if (target + run.dense == source + run.sparse) continue;
      // A run may overlap its own source.
      std::memmove(target + run.dense, source + run.sparse,
                   static_cast<std::size_t>(run.size) * sizeof(double));
    }
  }
  size_ = n;
}

void Covariance::spread(const std::vector<int>& rows, int size) {
  make_room(size);
  find_runs(rows);
  // Backwards, so that every number moves away from the origin before its place is taken.
  int next = size_ - 1;
  for (int j = size - 1; j >= 0; --j) {
    double* target = storage_.col(j).data();
    int end = size;
    if (next >= 0 && rows[static_cast<std::size_t>(next)] == j) {
      const double* source = storage_.col(next--).data();
      for (auto run = runs_.rbegin(); run != runs_.rend(); ++run) {
        // A run may overlap its own source.
        std::memmove(target + run->sparse, source + run->dense,
                     static_cast<std::size_t>(run->size) * sizeof(double));
        std::fill(target + run->sparse + run->size, target + end, 0.0);
        end = run->sparse;
      }
    }
    std::fill(target, target + end, 0.0);
  }
  size_ = size;
}

}  // namespace chasles
