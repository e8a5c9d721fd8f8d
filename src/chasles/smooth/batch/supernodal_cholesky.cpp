#include <algorithm>
#include <span>
#include <utility>

#include <Eigen/OrderingMethods>

#include <chasles/base/error.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/smooth/batch/batch.hpp>
#include <chasles/smooth/batch/supernodal_cholesky.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Sparse = Eigen::SparseMatrix<double>;
using Node = SupernodalCholesky::Node;

// The first columns of those that have the same rows as the ones before them, and one past the
// last. `all`: a symmetric matrix with both triangles.
std::vector<int> blocks_of(const Sparse& all) {
  const auto pattern = [&](int column) {
    const int* begin = all.outerIndexPtr() + column;
    return std::span(all.innerIndexPtr() + begin[0], all.innerIndexPtr() + begin[1]);
  };
  std::vector<int> first;
  for (int j = 0; j < all.cols(); ++j) {
    if (j == 0 || !std::ranges::equal(pattern(j - 1), pattern(j))) first.push_back(j);
  }
  first.push_back(static_cast<int>(all.cols()));
  return first;
}

// The places of the rows in an order of minimum degree, which is found of blocks of columns: an
// order of single ones takes as long as a factorisation.
std::vector<int> places_by_minimum_degree(const Sparse& lower) {
  const Sparse all = lower.selfadjointView<Eigen::Lower>();
  const std::vector<int> first = blocks_of(all);
  const int count = static_cast<int>(first.size()) - 1;
  std::vector<int> block_of(static_cast<std::size_t>(all.cols()));
  for (int b = 0; b < count; ++b) {
    const auto i = static_cast<std::size_t>(b);
    std::fill(block_of.begin() + first[i], block_of.begin() + first[i + 1], b);
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (int b = 0; b < count; ++b) {
    int last = -1;
    for (Sparse::InnerIterator it(all, first[static_cast<std::size_t>(b)]); it; ++it) {
      const int row = block_of[static_cast<std::size_t>(it.row())];
      if (std::exchange(last, row) != row) entries.emplace_back(row, b, 1);
    }
  }
  Sparse blocks(count, count);
  blocks.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> in_order;
  Eigen::AMDOrdering<int>()(blocks, in_order);
  std::vector<int> places(static_cast<std::size_t>(all.cols()));
  int place = 0;
  for (int i = 0; i < count; ++i) {
    const auto b = static_cast<std::size_t>(in_order.indices()[i]);
    for (int j = first[b]; j < first[b + 1]; ++j) places[static_cast<std::size_t>(j)] = place++;
  }
  return places;
}

// The lower triangle of P H P^T.
Sparse permuted(const Sparse& lower, const std::vector<int>& places) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<std::size_t>(lower.nonZeros()));
  for (int j = 0; j < lower.outerSize(); ++j) {
    for (Sparse::InnerIterator it(lower, j); it; ++it) {
      const int a = places[static_cast<std::size_t>(it.row())];
      const int b = places[static_cast<std::size_t>(j)];
      entries.emplace_back(std::max(a, b), std::min(a, b), it.value());
    }
  }
  Sparse H(lower.rows(), lower.cols());
  H.setFromTriplets(entries.begin(), entries.end());
  return H;
}

[[noreturn]] void throw_not_positive() {
  throw Error(ExitCode::kDiverged,
              "the normal matrix of the batch is not positive definite: a state or landmark is "
              "unobservable");
}

// What a node subtracts from the columns of its ancestors: the lower triangle, at its rows below.
// A node without children leaves it to its parent, which needs no memory for it then.
struct Update {
  const Node* node;
  MatrixXd matrix;
};

// The dense matrix of a node: its columns of H and what its children add, of all only the lower
// triangle. The columns of its ancestors are there if it has children.
class Front {
 public:
  Front(const Sparse& H, const Node& node, bool whole, std::vector<int>& row_in_front)
      : F_(MatrixXd::Zero(std::ssize(node.rows), whole ? std::ssize(node.rows) : node.width)),
        row_in_front_(&row_in_front) {
    for (int i = 0; i < std::ssize(node.rows); ++i) {
      row_in_front[static_cast<std::size_t>(node.rows[static_cast<std::size_t>(i)])] = i;
    }
    for (int c = 0; c < node.width; ++c) {
      for (Sparse::InnerIterator it(H, node.first + c); it; ++it) {
        F_(row_in_front[static_cast<std::size_t>(it.row())], c) = it.value();
      }
    }
  }

  void add(const Update& update, MatrixXd& workspace) {
    const Node& child = *update.node;
    const Index w = child.width, m = child.below();
    std::vector<Index> rows;
    for (std::size_t i = static_cast<std::size_t>(w); i < child.rows.size(); ++i) {
      rows.push_back((*row_in_front_)[static_cast<std::size_t>(child.rows[i])]);
    }
    if (update.matrix.size() == 0) {
      workspace.setZero(m, m);
      dense::downdate_lower(child.L.bottomRows(m), workspace);
    }
    const MatrixXd& all = update.matrix.size() > 0 ? update.matrix : workspace;
    for (Index c = 0; c < m; ++c) {
      double* column = F_.col(rows[static_cast<std::size_t>(c)]).data();
      const double* from = all.col(c).data();
      for (Index r = c; r < m; ++r) column[rows[static_cast<std::size_t>(r)]] += from[r];
    }
  }

  // Its columns of the factor into the node; returns what they and its children subtract.
  Update eliminate(Node& node) {
    const Index w = node.width, m = node.below();
    if (!dense::cholesky(F_.topLeftCorner(w, w))) throw_not_positive();
    if (m > 0) dense::solve_lower_from_right(F_.topLeftCorner(w, w), F_.bottomLeftCorner(m, w));
    node.L = F_.leftCols(w);
    if (m == 0 || F_.cols() == w) return {&node, {}};
    dense::downdate_lower(F_.bottomLeftCorner(m, w), F_.bottomRightCorner(m, m));
    return {&node, F_.bottomRightCorner(m, m)};
  }

 private:
  MatrixXd F_;
  std::vector<int>* row_in_front_;
};

}  // namespace

SupernodalCholesky::SupernodalCholesky(const Sparse& lower, const std::function<bool()>& stop)
    : place_(places_by_minimum_degree(lower)), node_of_(place_.size()) {
  const Sparse H = permuted(lower, place_);
  find_nodes(H);
  factorise(H, stop);
}

// From the left: the rows of a column are those of H, and those of the nodes whose first row below
// it is. It joins the node before it if it has just the remaining rows of that.
void SupernodalCholesky::find_nodes(const Sparse& H) {
  const int n = static_cast<int>(H.cols());
  std::vector<int> seen(static_cast<std::size_t>(n), -1);
  std::vector<std::vector<int>> children(static_cast<std::size_t>(n));  // nodes, of a column
  for (int j = 0; j < n; ++j) {
    const auto column = static_cast<std::size_t>(j);
    std::vector<int> rows;
    const auto add = [&](int row) {
      if (row < j || std::exchange(seen[static_cast<std::size_t>(row)], j) == j) return;
      rows.push_back(row);
    };
    add(j);
    for (Sparse::InnerIterator it(H, j); it; ++it) add(static_cast<int>(it.row()));
    for (const int child : children[column]) {
      for (const int row : nodes_[static_cast<std::size_t>(child)].rows) add(row);
    }
    bool joins = false;
    if (!nodes_.empty()) {
      Node& last = nodes_.back();
      joins = last.below() > 0 && last.rows[static_cast<std::size_t>(last.width)] == j &&
              last.below() == std::ssize(rows);
      if (joins) ++last.width;
    }
    if (!joins) {
      std::ranges::sort(rows);
      nodes_.push_back({.first = j, .width = 1, .rows = std::move(rows)});
    }
    node_of_[column] = static_cast<int>(nodes_.size()) - 1;
    const Node& node = nodes_.back();
    if (node.below() == 0) continue;
    children[static_cast<std::size_t>(node.rows[static_cast<std::size_t>(node.width)])].push_back(
        node_of_[column]);
  }
  for (Node& node : nodes_) {
    if (node.below() > 0) node.parent = node_of(node.rows[static_cast<std::size_t>(node.width)]);
  }
}

void SupernodalCholesky::factorise(const Sparse& H, const std::function<bool()>& stop) {
  std::vector<int> row_in_front(static_cast<std::size_t>(H.rows()));
  std::vector<std::vector<Update>> updates(nodes_.size());
  MatrixXd workspace;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (stop && stop()) throw BatchStopped();
    Node& node = nodes_[i];
    const std::vector<Update> of_children = std::exchange(updates[i], {});
    Front front(H, node, !of_children.empty(), row_in_front);
    for (const Update& update : of_children) front.add(update, workspace);
    Update update = front.eliminate(node);
    if (node.parent < 0) continue;
    updates[static_cast<std::size_t>(node.parent)].push_back(std::move(update));
  }
}

Eigen::VectorXd SupernodalCholesky::solve(const Eigen::VectorXd& b) const {
  Eigen::VectorXd x(b.size());
  for (int i = 0; i < b.size(); ++i) x[place(i)] = b[i];
  for (const Node& node : nodes_) {
    const Index w = node.width;
    auto own = x.segment(node.first, w);
    node.L.topRows(w).triangularView<Eigen::Lower>().solveInPlace(own);
    const Eigen::VectorXd change = node.L.bottomRows(node.below()) * own;
    for (Index i = 0; i < change.size(); ++i) {
      x[node.rows[static_cast<std::size_t>(w + i)]] -= change[i];
    }
  }
  for (auto node = nodes_.rbegin(); node != nodes_.rend(); ++node) {
    const Index w = node->width;
    auto own = x.segment(node->first, w);
    for (Index i = 0; i < node->below(); ++i) {
      own -= x[node->rows[static_cast<std::size_t>(w + i)]] * node->L.row(w + i).transpose();
    }
    node->L.topRows(w).triangularView<Eigen::Lower>().transpose().solveInPlace(own);
  }
  Eigen::VectorXd result(b.size());
  for (int i = 0; i < b.size(); ++i) result[i] = x[place(i)];
  return result;
}

}  // namespace chasles
