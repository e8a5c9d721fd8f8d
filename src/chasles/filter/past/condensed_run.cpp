#include <algorithm>
#include <iterator>
#include <utility>

#include <chasles/filter/dense.hpp>
#include <chasles/filter/past/condensed_run.hpp>
#include <chasles/filter/past/singular.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kMostOfItem = 6;

// C G C^T.
MatrixXd around(const MatrixXd& C, const MatrixXd& G) {
  const MatrixXd C_transposed = C.transpose();
  MatrixXd product = MatrixXd::Zero(C.rows(), C.rows());
  dense::add_product_lower(C, dense::product(G, C_transposed), product);
  dense::mirror_lower(product);
  return product;
}

}  // namespace

CondensedRun::Step CondensedRun::step_of(Segment segment) {
  const Index n = segment.starts, rows = segment.g.size() - n;
  Step step{.starts = n,
            .items = std::move(segment.items),
            .X = std::move(segment.X),
            .G_starts = segment.G.topLeftCorner(n, n),
            .own = MatrixXd::Zero(rows, kMostOfItem),
            .g = std::move(segment.g)};
  Index at = 0;
  for (const Segment::Item& item : step.items) {
    step.own.block(at, 0, item.size, item.size) =
        segment.G.block(n + at, n + at, item.size, item.size);
    at += item.size;
  }
  return step;
}

// From the end of the step to its start.
void CondensedRun::go_back(const Step& step, Later& later) {
  const MatrixXd by_start = step.X.leftCols(step.starts).transpose();
  later.g = by_start * later.g + step.g.head(step.starts);
  later.G = around(by_start, later.G) + step.G_starts;
}

void CondensedRun::add_to(Batch& batch, Step step) {
  const Index n = step.starts;
  if (batch.steps.empty()) {
    batch.X = step.X.leftCols(n);
    batch.later = {.G = step.G_starts, .g = step.g.head(n)};
  } else {
    const MatrixXd X_transposed = batch.X.transpose();
    batch.later.G += around(X_transposed, step.G_starts);
    batch.later.g += X_transposed * step.g.head(n);
    batch.X = dense::product(step.X.leftCols(n), batch.X);
  }
  batch.steps.push_back(std::make_shared<Step>(std::move(step)));
}

void CondensedRun::append(Segment segment, const MatrixXd& end) {
  if (work_) condense_step();
  add_to(current_, step_of(std::move(segment)));
  if (static_cast<int>(current_.steps.size()) < segments_) return;
  current_.end = end;
  if (after_) begin_work(std::move(*after_));
  after_ = std::exchange(current_, {});
}

// The connection x: what the end of the current batch has in common with the end of this one.
void CondensedRun::begin_work(Batch batch) {
  const MatrixXd L = regular_root(current_.end);
  MatrixXd scaled = dense::product(current_.X, regular_root(batch.end));
  dense::solve_lower(L, scaled);
  const MatrixXd Q = range_of(scaled), Q_transposed = Q.transpose(), L_transposed = L.transpose();
  const MatrixXd X_transposed = current_.X.transpose();
  MatrixXd in_scale = Q;
  L.triangularView<Eigen::Lower>().transpose().solveInPlace(in_scale);
  Work next{.batch = std::move(batch),
            .later = current_.later,
            .V = dense::product(X_transposed, in_scale),
            .K = dense::product(Q_transposed, L_transposed)};
  Condensed condensed;
  if (work_) {
    const MatrixXd by_next = dense::product(work_->K, next.V);
    const MatrixXd of_next = range_of(by_next), of_next_transposed = of_next.transpose();
    finish(condensed_.back(), {.G = around(work_->K, next.later.G), .g = work_->K * next.later.g},
           of_next);
    condensed.near = {.G = MatrixXd::Zero(of_next.cols(), of_next.cols()),
                      .g = VectorXd::Zero(of_next.cols())};
    condensed.by_next = dense::product(of_next_transposed, by_next);
  }
  condensed_.push_back(std::move(condensed));
  work_ = std::move(next);
}

// What is near has been measured, so that of x only Q^T x is of use.
void CondensedRun::finish(Condensed& batch, const Later& near, const MatrixXd& Q) const {
  const bool to_disk = bytes() - bytes_on_disk() > bytes_in_memory_;
  if (batch.by_next.size() > 0) {
    batch.near.G += around(batch.by_next, near.G);
    batch.near.g += batch.by_next * near.g;
    batch.by_next = dense::product(batch.by_next, Q);
  }
  const Index rank = Q.rows(), left = Q.cols();
  for (std::shared_ptr<const Rows>& step : batch.steps) {
    const MatrixXd U = step->rows.leftCols(rank), UG = dense::product(U, near.G);
    Rows finished{.items = step->items, .rows = MatrixXd(U.rows(), left + 1 + kMostOfItem)};
    finished.rows.leftCols(left) = dense::product(U, Q);
    finished.rows.rightCols(1 + kMostOfItem) = step->rows.rightCols(1 + kMostOfItem);
    finished.rows.col(left) += U * near.g;
    Index at = 0;
    for (const Segment::Item& item : step->items) {
      finished.rows.block(at, left + 1, item.size, item.size) +=
          UG.middleRows(at, item.size) * U.middleRows(at, item.size).transpose();
      at += item.size;
    }
    if (to_disk) finished.disk = disk_->put(finished.rows);
    if (finished.disk) finished.rows.resize(0, 0);
    step = std::make_shared<Rows>(std::move(finished));
  }
}

void CondensedRun::condense_step() {
  if (work_->batch.steps.empty()) return;
  const Step& step = *work_->batch.steps.back();
  const Index n = step.starts, rank = work_->V.cols();
  const MatrixXd C = step.X.rightCols(step.own.rows()).transpose();
  Rows result{.items = step.items, .rows = MatrixXd(step.own.rows(), rank + 1 + kMostOfItem)};
  result.rows.leftCols(rank) = dense::product(C, work_->V);
  Index at = 0;
  for (std::size_t i = 0; i < step.items.size(); ++i) {
    const SmoothedState state = smoothed(step, i, at, work_->later);
    const Index size = step.items[i].size;
    result.rows.block(at, rank, size, 1) = state.correction;
    result.rows.block(at, rank + 1, size, size) = state.covariance;
    at += size;
  }
  condensed_.back().steps.push_back(std::make_shared<Rows>(std::move(result)));
  go_back(step, work_->later);
  const MatrixXd by_start = step.X.leftCols(n).transpose();
  work_->V = dense::product(by_start, work_->V);
  work_->batch.steps.pop_back();
}

// `row`: of the items.
SmoothedState CondensedRun::smoothed(const Step& step, std::size_t item, Index row,
                                     const Later& later) {
  const Index size = step.items[item].size;
  const MatrixXd C = step.X.middleCols(step.starts + row, size).transpose();
  return {.number = step.items[item].number,
          .correction = step.g.segment(step.starts + row, size) + C * later.g,
          .covariance =
              step.own.block(row, 0, size, size) + dense::product(C, later.G) * C.transpose()};
}

// In front of those that left later.
void CondensedRun::prepend(const Step& step, const Later& later,
                           std::vector<SmoothedState>& states) {
  std::vector<SmoothedState> here;
  Index row = 0;
  for (std::size_t i = 0; i < step.items.size(); ++i) {
    here.push_back(without_rounding(smoothed(step, i, row, later)));
    row += step.items[i].size;
  }
  states.insert(states.begin(), std::make_move_iterator(here.begin()),
                std::make_move_iterator(here.end()));
}

// The states that are not condensed, and what all of these measurements do to the last x.
CondensedRun::Later CondensedRun::recent(const Segment* latest,
                                         std::vector<SmoothedState>& states) const {
  Later later;
  const auto sweep = [&](const Step& step) {
    if (later.g.size() == 0) {
      later = {.G = MatrixXd::Zero(step.X.rows(), step.X.rows()),
               .g = VectorXd::Zero(step.X.rows())};
    }
    prepend(step, later, states);
    go_back(step, later);
  };
  const auto sweep_batch = [&](const Batch& batch) {
    for (auto step = batch.steps.rbegin(); step != batch.steps.rend(); ++step) sweep(**step);
  };
  if (latest != nullptr) sweep(step_of(*latest));
  sweep_batch(current_);
  Later of_x;
  if (work_) {
    if (later.g.size() == 0) {
      later = {.G = MatrixXd::Zero(work_->K.cols(), work_->K.cols()),
               .g = VectorXd::Zero(work_->K.cols())};
    }
    of_x = {.G = around(work_->K, later.G), .g = work_->K * later.g};
  }
  if (after_) sweep_batch(*after_);
  if (work_) {
    later = {.G = work_->later.G + around(work_->V, of_x.G),
             .g = work_->later.g + work_->V * of_x.g};
    sweep_batch(work_->batch);
  }
  return of_x;
}

// Of the x of each condensed batch.
std::vector<CondensedRun::Later> CondensedRun::laters(const Later& last) const {
  std::vector<Later> result(condensed_.size());
  if (condensed_.empty()) return result;
  result.back() = last;
  for (std::size_t i = condensed_.size() - 1; i > 0; --i) {
    const Condensed& next = condensed_[i];
    result[i - 1] = {.G = next.near.G + around(next.by_next, result[i].G),
                     .g = next.near.g + next.by_next * result[i].g};
  }
  return result;
}

void CondensedRun::visit_rows(const Rows& step, const Later& later, const Visitor& visit) {
  const Index rank = later.g.size();
  const MatrixXd from_disk = step.disk ? step.disk->read() : MatrixXd();
  const MatrixXd& rows = step.disk ? from_disk : step.rows;
  Index at = 0;
  for (const Segment::Item& item : step.items) {
    const auto row = rows.middleRows(at, item.size);
    const MatrixXd U = row.leftCols(rank);
    visit(without_rounding(
        {.number = item.number,
         .correction = row.col(rank) + U * later.g,
         .covariance = row.middleCols(rank + 1, item.size) + U * (later.G * U.transpose())}));
    at += item.size;
  }
}

void CondensedRun::visit(const Segment& latest, const Visitor& visit) const {
  std::vector<SmoothedState> states;
  const std::vector<Later> all = laters(recent(&latest, states));
  for (std::size_t i = 0; i + 1 < condensed_.size(); ++i) visit_batch(condensed_[i], all[i], visit);
  // In the batch in work, those that are condensed left after those that are not.
  std::size_t left = 0;
  if (work_) {
    for (const auto& step : work_->batch.steps) left += step->items.size();
    for (std::size_t i = 0; i < left; ++i) visit(states[i]);
    visit_batch(condensed_.back(), all.back(), visit);
  }
  for (std::size_t i = left; i < states.size(); ++i) visit(states[i]);
}

void CondensedRun::visit_batch(const Condensed& batch, const Later& later, const Visitor& visit) {
  for (auto step = batch.steps.rbegin(); step != batch.steps.rend(); ++step) {
    visit_rows(**step, later, visit);
  }
}

void CondensedRun::give_up_older_half(const Visitor& visit) {
  const std::size_t half = condensed_.size() / 2;
  if (half == 0) return;
  std::vector<SmoothedState> states;
  const std::vector<Later> all = laters(recent(nullptr, states));
  for (std::size_t i = 0; i < half; ++i) visit_batch(condensed_[i], all[i], visit);
  condensed_.erase(condensed_.begin(), condensed_.begin() + static_cast<std::ptrdiff_t>(half));
}

std::size_t CondensedRun::bytes() const {
  Index numbers = 0;
  for (const Condensed& one : condensed_) {
    numbers += one.near.G.size() + one.by_next.size();
    for (const auto& step : one.steps) numbers += step->rows.size();
  }
  const auto add = [&](const Batch& batch) {
    for (const auto& step : batch.steps) {
      numbers += step->X.size() + step->G_starts.size() + step->own.size();
    }
  };
  add(current_);
  if (after_) add(*after_);
  if (work_) add(work_->batch);
  return sizeof(double) * static_cast<std::size_t>(numbers) + bytes_on_disk();
}

std::size_t CondensedRun::bytes_on_disk() const {
  Index numbers = 0;
  for (const Condensed& one : condensed_) {
    for (const auto& step : one.steps) numbers += step->disk ? step->disk->size() : 0;
  }
  return sizeof(double) * static_cast<std::size_t>(numbers);
}

}  // namespace chasles
