#include <algorithm>
#include <cstring>
#include <utility>

#include <chasles/filter/past/latest_segment.hpp>

namespace chasles {

using Eigen::Index;
using Eigen::MatrixXd;

void LatestSegment::make_room(Index variables, Index rows) {
  if (variables > Z_.rows() || rows > Z_.cols()) {
    MatrixXd larger(std::max(Z_.rows(), variables + variables / 4),
                    std::max(Z_.cols(), rows + rows / 4));
    larger.topLeftCorner(q_, n_) = Z();
    Z_ = std::move(larger);
  }
  if (variables > G_.rows()) {
    const Index room = Z_.rows();
    MatrixXd larger(room, room);
    larger.topLeftCorner(q_, q_) = G_.topLeftCorner(q_, q_);
    G_ = std::move(larger);
    g_.conservativeResize(room);
  }
}

void LatestSegment::clear(Index n) {
  segment_ = {};
  q_ = 0;
  n_ = n;
  make_room(q_, n_);
}

void LatestSegment::begin(Index n) {
  clear(n);
  make_room(n, n);
  q_ = n;
  segment_.starts = n;
  Z().setIdentity();
  G_.topLeftCorner(q_, q_).setZero();
  g_.head(q_).setZero();
}

void LatestSegment::append_rows(int count) {
  make_room(q_, n_ + count);
  Z_.block(0, n_, q_, count).setZero();
  n_ += count;
}

void LatestSegment::keep_rows(const std::vector<int>& rows) {
  n_ = static_cast<Index>(rows.size());
  if (q_ == 0) return;
  for (Index j = 0; j < n_; ++j) {  // rows rise, so no column is overwritten before it is read
    const Index from = rows[static_cast<std::size_t>(j)];
    if (from != j) Z_.col(j).head(q_) = Z_.col(from).head(q_);
  }
}

void LatestSegment::add_item(Segment::Item item, const MatrixXd& with_state, const MatrixXd& own,
                             const MatrixXd& with_variables) {
  const Index k = own.rows();
  make_room(q_ + k, n_);
  G_.block(q_, 0, k, q_) = with_variables.transpose();
  G_.block(q_, q_, k, k) = own;
  g_.segment(q_, k).setZero();
  q_ += k;
  Z().bottomRows(k) = with_state;
  segment_.items.push_back(item);
}

void LatestSegment::make_states(const std::vector<int>& numbers) {
  Segment changed = segment();
  take_along(changed, numbers);
  std::vector<int> others;
  for (const Segment::Item& item : changed.items) {
    if (!std::ranges::binary_search(numbers, item.number)) others.push_back(item.number);
  }
  changed = with_items(changed, others);
  segment_.items = changed.items;
  q_ = changed.g.size();
  make_room(q_, changed.X.rows());
  n_ = changed.X.rows();
  Z() = changed.X.transpose();
  G_.topLeftCorner(q_, q_) = changed.G;
  g_.head(q_) = changed.g;
}

void LatestSegment::correct(const Whitened& update) {
  if (q_ == 0) return;
  dense::subtract_outer(update.kept, update.W, Z());
  dense::downdate_lower(update.kept, G_.topLeftCorner(q_, q_));
  g_.head(q_).noalias() += update.kept * update.w;
}

Segment LatestSegment::segment() const {
  Segment result = segment_;
  result.X.resize(n_, q_);
  dense::transpose(Z(), result.X);
  result.G = G_.topLeftCorner(q_, q_);
  dense::mirror_lower(result.G);
  result.g = g_.head(q_);
  return result;
}

}  // namespace chasles
