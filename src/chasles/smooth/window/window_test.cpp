#include <Eigen/QR>
#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/filter/testing.hpp>
#include <chasles/smooth/window/window_run_detail.hpp>

// A window over a linear problem, against the least squares of the whole.
namespace chasles::smooth_detail {
namespace {

constexpr int kAdditive = 2, kErrors = 8;

// Residual A x - z over blocks of poses (their positions; the rotations have residuals that keep
// them at the identity), of additive states and of points.
class LinearCost final : public ceres::CostFunction {
 public:
  LinearCost(Eigen::MatrixXd A, Eigen::VectorXd z, const std::vector<int>& sizes)
      : A_(std::move(A)), z_(std::move(z)) {
    set_num_residuals(static_cast<int>(z_.size()));
    for (const int size : sizes) mutable_parameter_block_sizes()->push_back(size);
  }
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override {
    Eigen::Map<Eigen::VectorXd> r(residuals, num_residuals());
    r = -z_;
    Eigen::Index column = 0;
    for (std::size_t i = 0; i < parameter_block_sizes().size(); ++i) {
      const int size = parameter_block_sizes()[i];
      const Eigen::VectorXd e = errors(x[i], size);
      r += A_.middleCols(column, e.size()) * e;
      if (jacobians != nullptr && jacobians[i] != nullptr) {
        using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
        Eigen::Map<RowMajor> J(jacobians[i], num_residuals(), size);
        J.setZero();
        J.leftCols(e.size()) = A_.middleCols(column, e.size());
      }
      column += e.size();
    }
    return true;
  }

 private:
  static Eigen::VectorXd errors(const double* x, int size) {
    if (size != kPoseNumbers) return Eigen::Map<const Eigen::VectorXd>(x, size);
    Eigen::VectorXd e(kPoseErrors);
    const SE3 pose = read_pose(x);
    e << so3::log(pose.R), pose.p;
    return e;
  }

  Eigen::MatrixXd A_;
  Eigen::VectorXd z_;
};

// All terms of the run, over all keyframes and points.
class LeastSquares {
 public:
  void add(const std::vector<int>& columns, const Eigen::MatrixXd& A, const Eigen::VectorXd& z) {
    for (const int c : columns) size_ = std::max(size_, c + 1);
    terms_.push_back({columns, A, z});
  }
  void solve() {
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(size_, size_);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(size_);
    for (const Term& term : terms_) {
      H(term.columns, term.columns) += term.A.transpose() * term.A;
      g(term.columns) += term.A.transpose() * term.z;
    }
    // A landmark that is observed once is not determined and is excluded.
    P = H.completeOrthogonalDecomposition().pseudoInverse();
    x = P * g;
  }
  Eigen::MatrixXd P;
  Eigen::VectorXd x;

 private:
  struct Term {
    std::vector<int> columns;
    Eigen::MatrixXd A;
    Eigen::VectorXd z;
  };
  std::vector<Term> terms_;
  int size_ = 0;
};

// Twenty keyframes and landmarks of all kinds: observed three times, observed for twice the window,
// with a gap, throughout. Rotations have terms of their own that keep them at the identity.
class LinearScene {
 public:
  explicit LinearScene(int keyframes)
      : sliding(keyframes, settings(), kStandardChart, {.velocity = false, .additive = kAdditive}) {
  }

  static BatchSettings settings() {
    BatchSettings s;
    s.landmarks = LandmarkForm::kCartesian;
    s.loss = BatchLoss::kNone;
    s.gate = 0;
    return s;
  }

  bool seen(int point, int keyframe) const {
    if (point == 0) return true;
    const int since = keyframe - 2 * (point - 1);
    if (point % 3 == 0) return since >= 0 && since < 12;
    if (point % 3 == 1) return since >= 0 && since < 5 && since != 2;
    return since >= 0 && since < 3;
  }

  void add_keyframe() {
    sliding.make_room();
    const int k = count_++;
    std::array<double, kPoseNumbers> motion{};
    write_pose({}, motion.data());
    sliding.push({}, motion.data(), Eigen::VectorXd::Zero(kAdditive));
    sliding.window.keyframe(k).framed = true;
    add_term(k);
    for (int point = 0; point < 12; ++point) {
      if (seen(point, k)) add_view(point, k);
    }
    sliding.optimise(report);
    all.solve();
  }

  // [keyframe's errors] and points in the whole problem.
  std::vector<int> columns(int k) const {
    std::vector<int> rows = range(200 + kErrors * k, kErrors);
    return rows;
  }

  SlidingWindow sliding;
  WindowReport report;
  LeastSquares all;

 private:
  Eigen::MatrixXd matrix(int rows, int columns) {
    return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return random_.normal(); });
  }

  void add_term(int k) {
    // The link's information far exceeds all other information on the keyframe.
    const int n = k == 0 ? kErrors : 2 * kErrors;
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(kErrors, n);
    A.leftCols(kErrors) = (k == 0 ? 0.1 : -30) * Eigen::MatrixXd::Identity(kErrors, kErrors);
    A.block(3, 3, 5, 5) += matrix(5, 5);
    if (k > 0) A.rightCols(kErrors) = 30 * Eigen::MatrixXd::Identity(kErrors, kErrors);
    Eigen::VectorXd z = matrix(kErrors, 1);
    z.head<3>().setZero();
    std::vector<int> at = columns(k), sizes = {kPoseNumbers, kAdditive};
    if (k > 0) {
      std::vector<int> both = columns(k - 1);
      both.insert(both.end(), at.begin(), at.end());
      at = both;
      sizes = {kPoseNumbers, kAdditive, kPoseNumbers, kAdditive};
    }
    all.add(at, A, z);
    sliding.window.terms.push_back({.first = std::max(k - 1, 0),
                                    .keyframes = k > 0 ? 2 : 1,
                                    .cost = std::make_unique<LinearCost>(A, z, sizes)});
  }

  void add_view(int point, int k) {
    Eigen::MatrixXd A = matrix(2, 9);
    A.leftCols<3>().setZero();
    const Eigen::VectorXd z = matrix(2, 1);
    WindowView view{.keyframe = k};
    view.cost = std::make_unique<LinearCost>(A, z, std::vector<int>{kPoseNumbers, 3});
    const auto known = number_.find(point);
    // A landmark that has left returns as another one.
    if (known != number_.end() && sliding.window.points.contains(known->second)) {
      sliding.observe(known->second, std::move(view));
    } else {
      WindowPoint made{.id = point};
      made.views.push_back(std::move(view));
      number_[point] = sliding.add(std::move(made));
    }
    std::vector<int> at = range(200 + kErrors * k, 6);
    for (const int column : range(3 * number_[point], 3)) at.push_back(column);
    all.add(at, A, z);
  }

  test::Random random_{5};
  std::map<int, int> number_;
  int count_ = 0;
};

TEST(Window, OfALinearProblemKnowsAllThatTheWholeProblemDoes) {
  for (const int keyframes : {2, 3, 5, 20}) {
    LinearScene scene(keyframes);
    for (int k = 0; k < 20; ++k) {
      scene.add_keyframe();
      const WindowKeyframe& newest = scene.sliding.window.keyframes.back();
      Eigen::VectorXd x(kErrors);
      x << 0, 0, 0, read_pose(newest.motion.data()).p, newest.additive;
      const std::vector<int> at = scene.columns(k);
      EXPECT_LT((x - scene.all.x(at)).norm(), 1e-8) << keyframes << " at " << k;
      EXPECT_LT(test::covariance_difference(scene.sliding.newest_covariance(), scene.all.P(at, at)),
                1e-8);
    }
    EXPECT_EQ(scene.sliding.window.keyframes.size(), static_cast<std::size_t>(keyframes));
    EXPECT_EQ(scene.report.steps_rejected, 0);
  }
}

TEST(Window, RejectsFewerThanTwoKeyframes) {
  for (const int keyframes : {1, 0, -3}) EXPECT_THROW(LinearScene{keyframes}, UsageError);
}

}  // namespace
}  // namespace chasles::smooth_detail
