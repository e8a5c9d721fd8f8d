#include <algorithm>
#include <numeric>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <chasles/base/interruption.hpp>
#include <chasles/filter/covariance.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/filter/past/history_sweep_detail.hpp>

namespace chasles::filter_detail {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Correction = History::Correction;

// Information of later measurements on the errors d at some instant: exp(-d^T M d / 2 + y^T d).
// Only the lower triangle of M is stored.
struct Information {
  Covariance M;
  VectorXd y;
};

// Some rows of d+ as a function of d, given the later measurements: A d + g + noise of covariance
// G.
struct KnownNoise {
  MatrixXd A;
  VectorXd g;
  MatrixXd G;
};

// Result of a backward sweep, for the steps with noise.
using Sweep = std::vector<KnownNoise>;

MatrixXd symmetric(const MatrixXd& M) { return (M + M.transpose()) / 2; }

// (Q^-1 + M)^-1 for a small Q that may be singular.
MatrixXd informed_covariance(const MatrixXd& Q, const MatrixXd& M) {
  const MatrixXd identity = MatrixXd::Identity(Q.rows(), Q.rows());
  return symmetric((identity + Q * M).partialPivLu().solve(Q));
}

// The same for a Q of regular 3x3 blocks, which may be many: with Q = C C^T it is C (I + C^T M
// C)^-1 C^T, computed by a Cholesky factorisation.
MatrixXd informed_block_covariance(const MatrixXd& blocks, MatrixXd M) {
  const Index n = blocks.cols();
  MatrixXd Ct = MatrixXd::Zero(n, n);
  for (Index i = 0; i < n; i += 3) {
    const Eigen::Matrix3d L = blocks.middleCols<3>(i).llt().matrixL();
    Ct.block<3, 3>(i, i) = L.transpose();
    M.middleCols<3>(i) = M.middleCols<3>(i).lazyProduct(L).eval();
  }
  for (Index j = 0; j < n; j += 3) {
    for (Index i = j; i < n; i += 3) {
      M.block<3, 3>(i, j) = (Ct.block<3, 3>(i, i) * M.block<3, 3>(i, j)).eval();
    }
  }
  M.diagonal().array() += 1;
  dense::cholesky(M);
  dense::solve_lower(M, Ct);
  return dense::product(Ct.transpose().eval(), Ct);
}

// Rows [first, first + k) of d+ have noise, with the covariance G given the later measurements.
// Changes `later` to the information on d+ without the noise, and returns the noise as a function
// of d+ without it. `rows` are those rows of M.
KnownNoise take_out_noise(Information& later, Index first, const MatrixXd& rows, MatrixXd G) {
  KnownNoise known;
  known.G = std::move(G);
  known.g = known.G * later.y.segment(first, rows.rows());
  const MatrixXd columns = rows.transpose();
  known.A = MatrixXd::Zero(rows.rows(), rows.cols());
  dense::add_product(-1, known.G, rows, known.A);
  dense::add_product_lower(columns, known.A, later.M.all());
  later.y.noalias() -= columns * known.g;
  return known;
}

// The rows, before a removal, of the errors that remain.
std::vector<int> surviving_rows(const History::Removal& step, int core, int size_before) {
  std::vector<int> rows(static_cast<std::size_t>(core));
  std::iota(rows.begin(), rows.end(), 0);
  auto gone = step.indices.begin();
  for (int index = 0; core + 3 * index < size_before; ++index) {
    if (gone != step.indices.end() && *gone == index) {
      ++gone;
      continue;
    }
    for (int i = 0; i < 3; ++i) rows.push_back(core + 3 * index + i);
  }
  return rows;
}

// One step back in time: changes `later` from the errors after the step to those before it.
class Backward {
 public:
  Backward(int core, Information& later, Sweep& sweep)
      : core_(core), later_(later), sweep_(sweep) {}

  void operator()(const History::Propagation& step) {
    const Index n = step.F.rows();
    const MatrixXd rows = dense::symmetric_rows(later_.M.all(), 0, n);
    KnownNoise known =
        take_out_noise(later_, 0, rows, informed_covariance(step.Q, rows.leftCols(n)));
    known.A.leftCols(n) = (known.A.leftCols(n) * step.F).eval();
    known.A.leftCols(n) += step.F;
    change_leading(step.F);
    sweep_.push_back(std::move(known));
  }

  void operator()(const History::Addition& step) {
    const Index k = step.d_pose.rows();
    const Index n = later_.M.size() - k;
    const MatrixXd& J = step.d_pose;
    MatrixXd rows = dense::symmetric_rows(later_.M.all(), n, k);
    KnownNoise known =
        take_out_noise(later_, n, rows, informed_block_covariance(step.noise, rows.rightCols(k)));
    known.A.leftCols<6>() += dense::product(known.A.rightCols(k), J) + J;
    known.A.conservativeResize(Eigen::NoChange, n);
    // The new rows are J times those of the pose.
    auto M = later_.M.all();
    rows = dense::symmetric_rows(M, n, k);
    const MatrixXd MJ = dense::product(rows.transpose().eval(), J);
    M.topLeftCorner(n, 6) += MJ.topRows(n);
    M.topLeftCorner<6, 6>() += MJ.topRows<6>().transpose() + J.transpose() * MJ.bottomRows(k);
    later_.M.truncate(static_cast<int>(n));
    later_.y.head<6>() += J.transpose() * later_.y.tail(k);
    later_.y.conservativeResize(n);
    sweep_.push_back(std::move(known));
  }

  void operator()(const Correction& step) {
    pull_through_chart(step);
    auto M = later_.M.all();
    dense::add_symmetric_product(M, step.delta, later_.y);
    const Index core = step.core.rows();
    M.topLeftCorner(core, core) += step.core;
    later_.y.head(core) += step.core_vector;
    for (const Correction::OfLandmark& landmark : step.landmarks) {
      const Index row = core + 3 * landmark.index;
      M.block<3, 6>(row, 0) += landmark.with_pose.transpose();
      M.block<3, 3>(row, row) += landmark.own;
      later_.y.segment<3>(row) += landmark.vector;
    }
  }

  void operator()(const History::Removal& step) {
    const int n = later_.M.size() + 3 * static_cast<int>(step.indices.size());
    const std::vector<int> rows = surviving_rows(step, core_, n);
    later_.M.spread(rows, n);
    VectorXd y = VectorXd::Zero(n);
    y(rows) = later_.y;
    later_.y = std::move(y);
  }

  void operator()(const History::Pose&) {}

 private:
  // M <- A^T M A, y <- A^T y for an A that is the identity except for its first rows and columns.
  void change_leading(const MatrixXd& A) {
    const Index n = A.rows();
    auto M = later_.M.all();
    const MatrixXd At = A.transpose();
    const MatrixXd rows = dense::product(At, dense::symmetric_rows(M, 0, n));
    M.topLeftCorner(n, n) = rows.leftCols(n) * A;
    M.bottomLeftCorner(M.rows() - n, n) = rows.rightCols(M.rows() - n).transpose();
    later_.y.head(n) = (At * later_.y.head(n)).eval();
  }

  // M <- A^T M A, y <- A^T y
  void pull_through_chart(const Correction& step) {
    const Index k = step.A_landmarks.rows();
    if (step.A_motion.rows() > 0) change_leading(step.A_motion);
    if (k > 0) {
      auto M = later_.M.all();
      VectorXd& y = later_.y;
      MatrixXd B = MatrixXd::Zero(M.rows(), 3);
      B.bottomRows(k) = step.A_landmarks;
      const MatrixXd columns = dense::symmetric_product(M, B);
      M.leftCols<3>() += columns;
      M.topLeftCorner<3, 3>() +=
          columns.topRows<3>().transpose() + step.A_landmarks.transpose() * columns.bottomRows(k);
      y.head<3>() += step.A_landmarks.transpose() * y.tail(k);
    }
  }

  int core_;
  Information& later_;
  Sweep& sweep_;
};

// One step forward in time, given all measurements: the mean and covariance of the errors d, and
// their cross-covariance with the removed landmarks.
class Forward {
 public:
  Forward(int core, VectorXd d, const MatrixXd& P, const Sweep& sweep, const HistoryReader& reader)
      : core_(core),
        d_(std::move(d)),
        P_(P),
        known_(sweep.rbegin()),
        reader_(reader),
        gone_(MatrixXd::Zero(0, d_.size())) {}

  void operator()(const History::Propagation&) {
    const KnownNoise& known = *known_++;
    const Index k = known.A.rows();
    auto P = P_.all();
    d_.head(k) = known.A * d_ + known.g;
    const MatrixXd At = known.A.transpose();
    const MatrixXd columns = dense::product(P, At);
    P.topLeftCorner(k, k) = symmetric(dense::product(known.A, columns) + known.G);
    P.bottomLeftCorner(P.rows() - k, k) = columns.bottomRows(P.rows() - k);
    P.topRightCorner(k, P.cols() - k) = columns.bottomRows(P.rows() - k).transpose();
    if (reader_.covariance) gone_.leftCols(k) = dense::product(gone_, At);
  }

  void operator()(const History::Addition&) {
    const KnownNoise& known = *known_++;
    const Index k = known.A.rows();
    const Index n = P_.size();
    d_.conservativeResize(n + k);
    d_.tail(k) = known.A * d_.head(n) + known.g;
    P_.append(static_cast<int>(k));
    auto P = P_.all();
    const MatrixXd At = known.A.transpose();
    auto columns = P.topRightCorner(n, k);
    dense::add_product(1, P.topLeftCorner(n, n), At, columns);
    P.bottomLeftCorner(k, n) = columns.transpose();
    P.bottomRightCorner(k, k) = symmetric(dense::product(known.A, columns) + known.G);
    if (reader_.covariance) {
      gone_.conservativeResize(Eigen::NoChange, n + k);
      gone_.rightCols(k) = dense::product(gone_.leftCols(n), At);
    }
  }

  void operator()(const Correction& step) {
    const Index m = step.A_motion.rows();
    const Index k = step.A_landmarks.rows();
    auto P = P_.all();
    d_ -= step.delta;
    if (k > 0) {
      const MatrixXd At = step.A_landmarks.transpose();
      d_.tail(k) += step.A_landmarks * d_.head<3>();
      dense::add_product(1, P.leftCols<3>(), At, P.rightCols(k));
      dense::add_product(1, step.A_landmarks, P.topRows<3>(), P.bottomRows(k));
      if (reader_.covariance) dense::add_product(1, gone_.leftCols<3>(), At, gone_.rightCols(k));
    }
    if (m > 0) {
      const MatrixXd At = step.A_motion.transpose();
      d_.head(m) = (step.A_motion * d_.head(m)).eval();
      P.leftCols(m) = (P.leftCols(m) * At).eval();
      P.topRows(m) = (step.A_motion * P.topRows(m)).eval();
      if (reader_.covariance) gone_.leftCols(m) = (gone_.leftCols(m) * At).eval();
    }
  }

  void operator()(const History::Removal& step) {
    if (reader_.landmarks) reader_.landmarks(step, d_, std::as_const(P_).all());
    const std::vector<int> rows = surviving_rows(step, core_, P_.size());
    if (reader_.covariance) remove_with_covariance(step, rows);
    d_ = d_(rows).eval();
    P_.keep(rows);
  }

  void operator()(const History::Pose& step) {
    if (reader_.poses) reader_.poses(step, d_, std::as_const(P_).all());
  }

  // The state itself, after all removed landmarks: its landmarks, then the core.
  void finish() const {
    if (!reader_.covariance) return;
    std::vector<int> rows(static_cast<std::size_t>(P_.size()));
    std::iota(rows.begin(), rows.end(), 0);
    std::rotate(rows.begin(), rows.begin() + core_, rows.end());
    visit(gone_(Eigen::all, rows).transpose(), std::as_const(P_).all()(rows, rows));
  }

 private:
  void visit(const MatrixXd& with_gone, const MatrixXd& own) const {
    MatrixXd block(own.rows(), with_gone.cols() + own.cols());
    block << with_gone, own;
    reader_.covariance(with_gone.cols(), block);
  }

  void remove_with_covariance(const History::Removal& step, const std::vector<int>& rows) {
    const auto P = std::as_const(P_).all();
    std::vector<int> leaving;
    for (const int index : step.indices) {
      for (int i = 0; i < 3; ++i) leaving.push_back(core_ + 3 * index + i);
    }
    visit(gone_(Eigen::all, leaving).transpose(), P(leaving, leaving));
    const Index before = gone_.rows();
    MatrixXd next(before + static_cast<Index>(leaving.size()), static_cast<Index>(rows.size()));
    next.topRows(before) = gone_(Eigen::all, rows);
    next.bottomRows(next.rows() - before) = P(leaving, rows);
    gone_ = std::move(next);
  }

  int core_;
  VectorXd d_;
  Covariance P_;
  Sweep::const_reverse_iterator known_;
  const HistoryReader& reader_;
  MatrixXd gone_;  // cov(errors of the removed landmarks, d)
};

}  // namespace

void read(int core, const MatrixXd& initial, const std::vector<History::Step>& steps,
          Index size_now, const HistoryReader& reader) {
  Information later{Covariance(MatrixXd::Zero(size_now, size_now)), VectorXd::Zero(size_now)};
  Sweep sweep;
  Backward backward(core, later, sweep);
  for (auto step = steps.rbegin(); step != steps.rend(); ++step) {
    interruption_point();
    std::visit(backward, *step);
  }
  const MatrixXd P =
      informed_covariance(initial, MatrixXd(later.M.all().selfadjointView<Eigen::Lower>()));
  Forward forward(core, P * later.y, P, sweep, reader);
  for (const History::Step& step : steps) {
    interruption_point();
    std::visit(forward, step);
  }
  forward.finish();
}

}  // namespace chasles::filter_detail
