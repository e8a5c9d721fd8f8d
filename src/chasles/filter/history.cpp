#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <chasles/filter/dense.hpp>
#include <chasles/filter/history.hpp>
#include <algorithm>
#include <numeric>
#include <utility>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Correction = History::Correction;

// What later measurements say of the errors d at some instant: exp(-d^T M d / 2 + y^T d).
struct Information {
  MatrixXd M;
  VectorXd y;
};

// How some rows of d+ follow from all of d, once later measurements are known: A d + g + noise of
// covariance G.
struct KnownNoise {
  MatrixXd A;
  VectorXd g;
  MatrixXd G;
};

// One backward sweep leaves these, for the steps that have noise.
using Sweep = std::vector<KnownNoise>;

MatrixXd symmetric(const MatrixXd& M) { return (M + M.transpose()) / 2; }

// (Q^-1 + M)^-1 for a small Q that may be singular.
MatrixXd informed_covariance(const MatrixXd& Q, const MatrixXd& M) {
  const MatrixXd identity = MatrixXd::Identity(Q.rows(), Q.rows());
  return symmetric((identity + Q * M).partialPivLu().solve(Q));
}

// The same for a Q of regular 3x3 blocks, which may be many: with Q = C C^T it is
// C (I + C^T M C)^-1 C^T, and the inverse is a Cholesky factorisation away.
MatrixXd informed_block_covariance(const MatrixXd& blocks, MatrixXd M) {
  const Index n = blocks.cols();
  MatrixXd C = MatrixXd::Zero(n, n);
  for (Index i = 0; i < n; i += 3) {
    const Eigen::Matrix3d L = blocks.middleCols<3>(i).llt().matrixL();
    C.block<3, 3>(i, i) = L;
    M.middleRows<3>(i) = (L.transpose() * M.middleRows<3>(i)).eval();
  }
  for (Index i = 0; i < n; i += 3) {
    M.middleCols<3>(i) = (M.middleCols<3>(i) * C.block<3, 3>(i, i)).eval();
  }
  M.diagonal().array() += 1;
  dense::cholesky(M);
  C.transposeInPlace();
  dense::solve_lower(M, C);
  return dense::product(C.transpose().eval(), C);
}

// Rows [first, first + k) of d+ have noise, whose covariance, known what is later known, is
// informed(M of those rows): that is told of d+ without the noise, and the noise of d+ without it.
template <typename Informed>
KnownNoise take_out_noise(Information& later, Index first, Index k, const Informed& informed) {
  const MatrixXd rows = later.M.middleRows(first, k);
  KnownNoise known;
  known.G = informed(rows.middleCols(first, k));
  known.g = known.G * later.y.segment(first, k);
  known.A = -dense::product(known.G, rows);
  dense::add_product(1, rows.transpose().eval(), known.A, later.M);
  later.y -= rows.transpose() * known.g;
  return known;
}

// The rows, before a removal, of the errors that survive it.
std::vector<Index> surviving_rows(const History::Removal& step, Index core, Index size_before) {
  std::vector<Index> rows;
  for (Index i = 0; i < core; ++i) rows.push_back(i);
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

// One step back in time: `later` holds for the errors after the step and becomes what holds before.
class Backward {
 public:
  Backward(Index core, Information& later, Sweep& sweep)
      : core_(core), later_(later), sweep_(sweep) {}

  void operator()(const History::Propagation& step) {
    const Index n = step.F.rows();
    KnownNoise known = take_out_noise(
        later_, 0, n, [&](const MatrixXd& M) { return informed_covariance(step.Q, M); });
    known.A.leftCols(n) = (known.A.leftCols(n) * step.F).eval();
    known.A.leftCols(n) += step.F;
    later_.M.topRows(n) = (step.F.transpose() * later_.M.topRows(n)).eval();
    later_.M.leftCols(n) = (later_.M.leftCols(n) * step.F).eval();
    later_.y.head(n) = (step.F.transpose() * later_.y.head(n)).eval();
    sweep_.push_back(std::move(known));
  }

  void operator()(const History::Addition& step) {
    const Index k = step.d_pose.rows();
    const Index n = later_.M.rows() - k;
    const MatrixXd& J = step.d_pose;
    KnownNoise known = take_out_noise(later_, n, k, [&](const MatrixXd& M) {
      return informed_block_covariance(step.noise, M);
    });
    known.A.leftCols<6>() += known.A.rightCols(k) * J + J;
    known.A = known.A.leftCols(n).eval();
    // The new rows are now J times those of the pose.
    MatrixXd& M = later_.M;
    M.topRows<6>() += (J.transpose() * M.bottomRows(k)).eval();
    M.leftCols<6>() += (M.rightCols(k) * J).eval();
    M = M.topLeftCorner(n, n).eval();
    later_.y.head<6>() += J.transpose() * later_.y.tail(k);
    later_.y = later_.y.head(n).eval();
    sweep_.push_back(std::move(known));
  }

  void operator()(const Correction& step) {
    pull_through_chart(step);
    later_.y += later_.M * step.delta;
    const Index core = step.core.rows();
    later_.M.topLeftCorner(core, core) += step.core;
    later_.y.head(core) += step.core_vector;
    for (const Correction::OfLandmark& landmark : step.landmarks) {
      const Index row = core + 3 * landmark.index;
      later_.M.block<6, 3>(0, row) += landmark.with_pose;
      later_.M.block<3, 6>(row, 0) += landmark.with_pose.transpose();
      later_.M.block<3, 3>(row, row) += landmark.own;
      later_.y.segment<3>(row) += landmark.vector;
    }
  }

  void operator()(const History::Removal& step) {
    const Index n = later_.M.rows() + 3 * static_cast<Index>(step.indices.size());
    const std::vector<Index> rows = surviving_rows(step, core_, n);
    Information earlier{MatrixXd::Zero(n, n), VectorXd::Zero(n)};
    earlier.M(rows, rows) = later_.M;
    earlier.y(rows) = later_.y;
    later_ = std::move(earlier);
  }

 private:
  // M <- A^T M A, y <- A^T y
  void pull_through_chart(const Correction& step) {
    const Index m = step.A_motion.rows();
    const Index k = step.A_landmarks.rows();
    MatrixXd& M = later_.M;
    VectorXd& y = later_.y;
    if (m > 0) {
      M.topRows(m) = (step.A_motion.transpose() * M.topRows(m)).eval();
      M.leftCols(m) = (M.leftCols(m) * step.A_motion).eval();
      y.head(m) = (step.A_motion.transpose() * y.head(m)).eval();
    }
    if (k > 0) {
      M.topRows<3>() += step.A_landmarks.transpose() * M.bottomRows(k);
      M.leftCols<3>() += M.rightCols(k) * step.A_landmarks;
      y.head<3>() += step.A_landmarks.transpose() * y.tail(k);
    }
  }

  Index core_;
  Information& later_;
  Sweep& sweep_;
};

// One step forward in time, with everything known: the mean and covariance of the errors d, and the
// cross-covariance of the landmarks that have gone with them.
class Forward {
 public:
  // Called at a removal and at the end: the removed landmarks' errors (rows of `removal`; all rows
  // where it is null), before they go.
  struct Reader {
    std::function<void(const History::Removal&, const VectorXd& d, const MatrixXd& P)> landmarks;
    History::RowVisitor covariance;  // null: not asked for
  };

  Forward(Index core, VectorXd d, MatrixXd P, const Sweep& sweep, const Reader& reader)
      : core_(core),
        d_(std::move(d)),
        P_(std::move(P)),
        known_(sweep.rbegin()),
        reader_(reader),
        gone_(MatrixXd::Zero(0, core)) {}

  void operator()(const History::Propagation&) {
    const KnownNoise& known = *known_++;
    const Index k = known.A.rows();
    d_.head(k) = known.A * d_ + known.g;
    const MatrixXd rows = dense::product(known.A, P_);
    P_.topLeftCorner(k, k) = symmetric(rows * known.A.transpose() + known.G);
    P_.topRightCorner(k, P_.cols() - k) = rows.rightCols(P_.cols() - k);
    P_.bottomLeftCorner(P_.rows() - k, k) = rows.rightCols(P_.cols() - k).transpose();
    if (reader_.covariance) gone_.leftCols(k) = dense::product(gone_, known.A.transpose().eval());
  }

  void operator()(const History::Addition&) {
    const KnownNoise& known = *known_++;
    const Index k = known.A.rows();
    const Index n = P_.rows();
    const MatrixXd rows = dense::product(known.A, P_);
    d_.conservativeResize(n + k);
    d_.tail(k) = known.A * d_.head(n) + known.g;
    P_.conservativeResize(n + k, n + k);
    P_.bottomLeftCorner(k, n) = rows;
    P_.topRightCorner(n, k) = rows.transpose();
    P_.bottomRightCorner(k, k) = symmetric(rows * known.A.transpose() + known.G);
    if (reader_.covariance) {
      gone_.conservativeResize(Eigen::NoChange, n + k);
      gone_.rightCols(k) = dense::product(gone_.leftCols(n), known.A.transpose().eval());
    }
  }

  void operator()(const Correction& step) {
    const Index m = step.A_motion.rows();
    const Index k = step.A_landmarks.rows();
    const auto apply = [&](auto&& columns) {  // columns · A^T, for columns as a row-wise block
      if (k > 0) columns.rightCols(k) += columns.leftCols(3) * step.A_landmarks.transpose();
      if (m > 0) columns.leftCols(m) = (columns.leftCols(m) * step.A_motion.transpose()).eval();
    };
    d_ -= step.delta;
    apply(d_.transpose());
    if (m == 0 && k == 0) return;
    apply(P_);
    apply(P_.transpose());
    if (reader_.covariance) apply(gone_);
  }

  void operator()(const History::Removal& step) {
    if (reader_.landmarks) reader_.landmarks(step, d_, P_);
    const std::vector<Index> rows = surviving_rows(step, core_, P_.rows());
    if (reader_.covariance) remove_with_covariance(step, rows);
    d_ = d_(rows).eval();
    P_ = P_(rows, rows).eval();
  }

  // The state itself, behind all that has gone: its landmarks, then the core.
  void finish() const {
    if (!reader_.covariance) return;
    std::vector<Index> rows(static_cast<std::size_t>(P_.rows()));
    std::iota(rows.begin(), rows.end(), 0);
    std::rotate(rows.begin(), rows.begin() + core_, rows.end());
    visit(gone_(Eigen::all, rows).transpose(), P_(rows, rows));
  }

 private:
  void visit(const MatrixXd& with_gone, const MatrixXd& own) const {
    MatrixXd block(own.rows(), with_gone.cols() + own.cols());
    block << with_gone, own;
    reader_.covariance(with_gone.cols(), block);
  }

  void remove_with_covariance(const History::Removal& step, const std::vector<Index>& rows) {
    std::vector<Index> leaving;
    for (const int index : step.indices) {
      for (int i = 0; i < 3; ++i) leaving.push_back(core_ + 3 * index + i);
    }
    visit(gone_(Eigen::all, leaving).transpose(), P_(leaving, leaving));
    const Index before = gone_.rows();
    MatrixXd next(before + static_cast<Index>(leaving.size()), static_cast<Index>(rows.size()));
    next.topRows(before) = gone_(Eigen::all, rows);
    next.bottomRows(next.rows() - before) = P_(leaving, rows);
    gone_ = std::move(next);
  }

  Index core_;
  VectorXd d_;
  MatrixXd P_;
  Sweep::const_reverse_iterator known_;
  const Reader& reader_;
  MatrixXd gone_;  // cov(errors of the landmarks that have gone, d)
};

void read(const MatrixXd& initial, const std::vector<History::Step>& steps, Index size_now,
          const Forward::Reader& reader) {
  const Index core = initial.rows();
  Information later{MatrixXd::Zero(size_now, size_now), VectorXd::Zero(size_now)};
  Sweep sweep;
  Backward backward(core, later, sweep);
  for (auto step = steps.rbegin(); step != steps.rend(); ++step) std::visit(backward, *step);
  const MatrixXd P = informed_covariance(initial, later.M);
  Forward forward(core, P * later.y, P, sweep, reader);
  for (const History::Step& step : steps) std::visit(forward, step);
  forward.finish();
}

}  // namespace

void History::append(Step step) {
  if (const auto* addition = std::get_if<Addition>(&step)) {
    state_landmarks_ += static_cast<int>(addition->d_pose.rows() / 3);
  } else if (const auto* removal = std::get_if<Removal>(&step)) {
    state_landmarks_ -= static_cast<int>(removal->indices.size());
    removed_ += static_cast<int>(removal->indices.size());
  }
  steps_.push_back(std::move(step));
}

std::vector<MapLandmark> History::landmarks() const {
  std::vector<MapLandmark> result;
  result.reserve(static_cast<std::size_t>(removed_));
  const Index core = initial_.rows();
  const auto take = [&](const Removal& removal, const VectorXd& d, const MatrixXd& P) {
    for (std::size_t i = 0; i < removal.indices.size(); ++i) {
      const Landmark& landmark = removal.landmarks[i];
      const Index row = core + 3 * removal.indices[i];
      result.push_back({.id = landmark.id,
                        .p_world = landmark.p_world + d.segment<3>(row),
                        .covariance = P.block<3, 3>(row, row),
                        .observations = landmark.observations});
    }
  };
  read(initial_, steps_, core + 3 * state_landmarks_, {.landmarks = take, .covariance = nullptr});
  return result;
}

void History::visit_covariance(const RowVisitor& visit) const {
  read(initial_, steps_, initial_.rows() + 3 * state_landmarks_,
       {.landmarks = nullptr, .covariance = visit});
}

}  // namespace chasles
