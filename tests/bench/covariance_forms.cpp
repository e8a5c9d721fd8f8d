#include "covariance_forms.hpp"

#include <algorithm>

#include <Eigen/QR>

namespace chasles::bench {
namespace {

constexpr Eigen::Index kCapacity = 424;  // not a power of two: columns would share cache lines
constexpr Eigen::Index kLeafRows = 32;   // as in whitening.cpp
constexpr Eigen::Index kTurned = 16;     // columns that are triangularised together

/// B = turn^T [0; L].
template <typename S>
struct Ql {
  MatrixOf<S> turn, L;
};

// L from the QR of B with rows and columns in reverse.
template <typename S>
Ql<S> ql(const MatrixOf<S>& B, bool with_turn) {
  const Eigen::HouseholderQR<MatrixOf<S>> qr(B.reverse());
  const Eigen::Index n = B.cols();
  const MatrixOf<S> R = qr.matrixQR().topRows(n).template triangularView<Eigen::Upper>();
  Ql<S> result{.turn = {}, .L = R.reverse()};
  if (with_turn) {
    const MatrixOf<S> Q = qr.householderQ();
    result.turn = Q.reverse().transpose();
  }
  return result;
}

// target += M d^T for d of three or six columns.
template <typename S, typename Columns, typename Target>
void add_columns(const typename Work<S>::Part& part, const Columns& M, Target target) {
  if (part.d.cols() == 3) {
    target += M.template leftCols<3>().lazyProduct(part.d.template leftCols<3>().transpose());
  } else {
    target += M.template leftCols<6>().lazyProduct(part.d.template leftCols<6>().transpose());
  }
}

// X <- L^-1 X by halves: OpenBLAS's products are faster than its triangular solver.
template <typename S>
void solve_block(const ConstBlockOf<S>& L, BlockOf<S> X) {
  const Eigen::Index n = L.rows();
  if (n <= kLeafRows) return solve_lower<S>(L, X);
  const Eigen::Index k = n / 2;
  solve_block<S>(L.topLeftCorner(k, k), X.topRows(k));
  add_product<S>(-1, L.bottomLeftCorner(n - k, k), X.topRows(k), X.bottomRows(n - k));
  solve_block<S>(L.bottomRightCorner(n - k, n - k), X.bottomRows(n - k));
}

// The same for a lower triangular U.
template <typename S>
void solve_triangle(const ConstBlockOf<S>& L, BlockOf<S> U) {
  const Eigen::Index n = L.rows();
  if (n <= kLeafRows) return solve_lower<S>(L, U);
  const Eigen::Index k = n / 2;
  solve_triangle<S>(L.topLeftCorner(k, k), U.topLeftCorner(k, k));
  auto corner = U.bottomLeftCorner(n - k, k);
  add_product<S>(-1, L.bottomLeftCorner(n - k, k), U.topLeftCorner(k, k), corner);
  solve_block<S>(L.bottomRightCorner(n - k, n - k), corner);
  solve_triangle<S>(L.bottomRightCorner(n - k, n - k), U.bottomRightCorner(n - k, n - k));
}

}  // namespace

template <typename S>
DenseForm<S>::DenseForm(const Eigen::MatrixXd& core_covariance)
    : P_(MatrixOf<S>::Zero(kCapacity, kCapacity)),
      core_(static_cast<int>(core_covariance.rows())),
      size_(core_) {
  all() = core_covariance.cast<S>();
}

template <typename S>
Eigen::MatrixXd DenseForm<S>::covariance() const {
  return P_.topLeftCorner(size_, size_).template cast<double>();
}

template <typename S>
void DenseForm<S>::propagate(const Work<S>& w) {
  auto P = all();
  const int n = core_;
  P.topRows(n) = (w.F * P.topRows(n)).eval();
  P.topLeftCorner(n, n) = (P.topLeftCorner(n, n) * w.F.transpose() + w.Q).eval();
  P.bottomLeftCorner(size_ - n, n) = P.topRightCorner(n, size_ - n).transpose();
}

template <typename S>
void DenseForm<S>::exchange(const Work<S>& w) {
  const auto kept = static_cast<int>(w.keep.size());
  const auto k = static_cast<int>(w.d_pose.rows());
  for (int j = 0; j < kept; ++j) {
    const S* source = P_.col(w.keep[static_cast<std::size_t>(j)]).data();
    S* target = P_.col(j).data();
    for (int i = 0; i < kept; ++i) target[i] = source[w.keep[static_cast<std::size_t>(i)]];
  }
  const MatrixOf<S> cross = w.d_pose * P_.topLeftCorner(6, kept);
  P_.block(kept, 0, k, kept) = cross;
  P_.block(0, kept, kept, k) = cross.transpose();
  P_.block(kept, kept, k, k) = cross.leftCols(6) * w.d_pose.transpose() + w.noise;
  size_ = kept + k;
}

// H M for the rows of H from `first` on, as many as HM has.
template <typename S>
void DenseForm<S>::apply_H(const Work<S>& w, Eigen::Index first, const MatrixOf<S>& M,
                           MatrixOf<S>& HM) const {
  HM = product<S>(w.H_core.middleRows(first, HM.rows()), M.topRows(core_));
  for (const auto& part : w.H_parts) {
    if (part.at < first || part.at >= first + HM.rows()) continue;
    auto rows = HM.middleRows(part.at - first, part.d.rows());
    if (part.d.cols() == 3) {
      rows += part.d.template leftCols<3>().lazyProduct(M.template middleRows<3>(part.row));
    } else {
      rows += part.d.template leftCols<6>().lazyProduct(M.template middleRows<6>(part.row));
    }
  }
}

// The algorithm of whitening.cpp, by halves, for noise 1. W and e belong to the rows of H from
// `first` on.
template <typename S>
bool DenseForm<S>::whiten(const Work<S>& w, Eigen::Index first, BlockOf<S> W,
                          Eigen::Ref<VectorOf<S>> e) const {
  const Eigen::Index m = e.size();
  if (m <= kLeafRows) {
    MatrixOf<S> HW(m, m);
    apply_H(w, first, W, HW);
    HW.diagonal().array() += S(1);
    if (!cholesky<S>(HW)) return false;
    solve_lower<S>(HW, W, true);
    MatrixOf<S> column = e;
    solve_lower<S>(HW, column);
    e = column;
    return true;
  }
  const Eigen::Index k = m / 4 * 2;  // measurements have two rows
  if (!whiten(w, first, W.leftCols(k), e.head(k))) return false;
  MatrixOf<S> HW(m - k, k);
  apply_H(w, first + k, W.leftCols(k), HW);
  add_product<S>(-1, W.leftCols(k), HW.transpose().eval(), W.rightCols(m - k));
  e.tail(m - k).noalias() -= HW * e.head(k);
  return whiten(w, first + k, W.rightCols(m - k), e.tail(m - k));
}

template <typename S>
bool DenseForm<S>::update(const Work<S>& w) {
  if (w.residual.size() == 0) return true;
  auto P = all();
  MatrixOf<S> W = product<S>(P.leftCols(core_), w.H_core.transpose().eval());
  for (const auto& part : w.H_parts) {
    add_columns<S>(part, P.rightCols(size_ - part.row), W.middleCols(part.at, part.d.rows()));
  }
  VectorOf<S> e = w.residual;
  if (!whiten(w, 0, W, e)) return false;
  correction_.noalias() = W * e;
  add_square_lower<S>(-1, W, P);
  mirror_lower<S>(P);
  return true;
}

template <typename S>
RootForm<S>::RootForm(const Eigen::MatrixXd& core_covariance)
    : U_(MatrixOf<S>::Zero(kCapacity, kCapacity)),
      A_(kCapacity, kCapacity),
      L_(kCapacity, kCapacity),
      core_(static_cast<int>(core_covariance.rows())),
      size_(core_) {
  all() = ql<S>(root(core_covariance).cast<S>(), false).L;
}

template <typename S>
Eigen::MatrixXd RootForm<S>::covariance() const {
  const Eigen::MatrixXd U = U_.bottomRightCorner(size_, size_).template cast<double>();
  return U.transpose() * U;
}

template <typename S>
void RootForm<S>::propagate(const Work<S>& w) {
  auto U = all();
  const int c = core_;
  U.leftCols(c) = product<S>(U.leftCols(c), w.F.transpose().eval());
  MatrixOf<S> B(2 * c, c);
  B << U.topLeftCorner(c, c), w.G;
  U.topLeftCorner(c, c) = ql<S>(B, false).L;
}

template <typename S>
void RootForm<S>::drop(const std::vector<int>& keep) {
  const auto kept = static_cast<Eigen::Index>(keep.size());
  const Eigen::Index d = size_ - kept;
  if (d == 0) return;
  auto U = all();
  for (Eigen::Index j = kept - 1; j >= 0; --j) {
    const int source = keep[static_cast<std::size_t>(j)];
    if (source != j + d) U.col(j + d) = U.col(source).eval();
  }
  auto V = U.rightCols(kept);
  for (Eigen::Index end = kept; end > 0;) {
    const Eigen::Index begin = std::max<Eigen::Index>(0, end - kTurned);
    const Eigen::Index top = keep[static_cast<std::size_t>(begin)];
    const Eigen::Index rows = end + d - top;
    if (rows > end - begin) {
      const Ql<S> turned = ql<S>(V.block(top, begin, rows, end - begin), true);
      V.block(top, begin, rows, end - begin) << MatrixOf<S>::Zero(rows - end + begin, end - begin),
          turned.L;
      V.block(top, 0, rows, begin) = product<S>(turned.turn, V.block(top, 0, rows, begin));
    }
    end = begin;
  }
  size_ = static_cast<int>(kept);
}

template <typename S>
void RootForm<S>::add(const Work<S>& w) {
  const auto k = static_cast<int>(w.d_pose.rows());
  if (k == 0) return;
  const int c = core_;
  MatrixOf<S> columns(size_, c + k);
  columns << all().leftCols(c), product<S>(all().leftCols(6), w.d_pose.transpose().eval());
  size_ += k;
  auto U = all();
  U.topRows(c + k).setZero();
  U.block(c + k, 0, size_ - c - k, c + k) = columns.bottomRows(size_ - c - k);
  MatrixOf<S> B = MatrixOf<S>::Zero(c + k, c + k);
  B.topRows(c) = columns.topRows(c);
  B.bottomRightCorner(k, k) = w.noise_root;
  U.topLeftCorner(c + k, c + k) = ql<S>(B, false).L;
}

template <typename S>
void RootForm<S>::exchange(const Work<S>& w) {
  drop(w.keep);
  add(w);
}

template <typename S>
bool RootForm<S>::update(const Work<S>& w) {
  if (w.residual.size() == 0) return true;
  auto U = all();
  const Eigen::Index n = size_;
  auto A = A_.topLeftCorner(n, w.residual.size());
  A.setZero();
  add_product<S>(1, U.leftCols(core_), w.H_core.transpose().eval(), A);
  for (const auto& part : w.H_parts) {
    const Eigen::Index r = part.row;
    add_columns<S>(part, U.block(r, r, n - r, n - r), A.block(r, part.at, n - r, part.d.rows()));
  }
  auto L = L_.topLeftCorner(n, n);
  L.setIdentity();
  add_square_lower<S>(1, A, L);
  if (!cholesky<S>(L)) return false;
  MatrixOf<S> e = A * w.residual;
  solve_lower<S>(L, e);
  solve_triangle<S>(L, U);
  correction_.noalias() = U.transpose() * e.col(0);
  return true;
}

template class DenseForm<float>;
template class DenseForm<double>;
template class RootForm<float>;
template class RootForm<double>;

}  // namespace chasles::bench
