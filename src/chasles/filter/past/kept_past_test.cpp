#include <array>
#include <numeric>
#include <string>

#include <Eigen/LU>

#include <chasles/base/error.hpp>
#include <chasles/filter/past/past_view.hpp>
#include <chasles/filter/random_ekf_testing.hpp>

// The past of a filter that makes linear steps, against the joint Gaussian of the state and of all
// that has left it.

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Map = KeptPast::Map;

constexpr Index kPastCore = 9;
constexpr double kJointTolerance = 1e-9;

// Errors of the state, then those of what has left.
struct JointGaussian {
  Index n;
  MatrixXd P;
  VectorXd correction;  // of the means of what has left

  explicit JointGaussian(MatrixXd initial) : n(initial.rows()), P(std::move(initial)) {}

  Index left() const { return P.rows() - n; }
  Covariance state() const { return Covariance(P.topLeftCorner(n, n)); }

  // d+ = M d; of other size, too.
  void transform(const MatrixXd& M) {
    const Index k = left();
    const MatrixXd own = M * P.topLeftCorner(n, n) * M.transpose(),
                   cross = M * P.topRightCorner(n, k), others = P.bottomRightCorner(k, k);
    n = M.rows();
    P.resize(n + k, n + k);
    P << own, cross, cross.transpose(), others;
  }

  // D d leaves.
  void leave(const MatrixXd& D) {
    const MatrixXd all = P, with_all = D * P.topRows(n);
    P.resize(all.rows() + D.rows(), all.rows() + D.rows());
    P << all, with_all.transpose(), with_all, with_all.leftCols(n) * D.transpose();
    const VectorXd before = correction;
    correction.setZero(left());
    correction.head(before.size()) = before;
  }

  void update(const MatrixXd& H, const MatrixXd& R, const VectorXd& r) {
    const MatrixXd PHt = P.leftCols(n) * H.transpose();
    const MatrixXd K = PHt * (H * PHt.topRows(n) + R).inverse();
    P = (P - K * PHt.transpose()).eval();
    correction += K.bottomRows(left()) * r;
  }
};

MatrixXd identity_with(Index n, Index row, Index column, const MatrixXd& block) {
  MatrixXd M = MatrixXd::Identity(n, n);
  M.block(row, column, block.rows(), block.cols()) = block;
  return M;
}

// A KeptPast and its reference make the same steps.
class LinearSteps {
 public:
  LinearSteps()
      : joint_(test::random_covariance(random_, kPastCore, 0.3)), kept_(joint_.P, options()) {
    x_.additive.setZero(kPastCore - 6);
  }

  static KeptPast::Options options() {
    return {.map = Map::kPast, .past = {.recalls = true, .records = true}};
  }

  const JointGaussian& joint() const { return joint_; }
  PastView view(const Covariance& state) const { return {kept_, x_, state}; }
  const std::vector<int>& landmarks() const { return landmarks_; }
  const std::vector<Index>& first_rows() const { return first_rows_; }

  void step() {
    propagate();
    grow();
    change_coordinates();
    correct();
    leave();
  }

 private:
  MatrixXd random(Index rows, Index cols) {
    return 0.03 * test::random_matrix(random_, rows, cols);
  }

  void propagate() {
    const MatrixXd F = MatrixXd::Identity(kPastCore, kPastCore) + random(kPastCore, kPastCore);
    const MatrixXd Q = test::random_covariance(random_, kPastCore, 0.1);
    kept_.propagate(F, Q, joint_.state());
    joint_.transform(identity_with(joint_.n, 0, 0, F));
    joint_.P.topLeftCorner(kPastCore, kPastCore) += Q;
  }

  // A clone, a landmark of it and of the pose, and a function of all errors.
  void grow() {
    const Index clone = joint_.n, landmark = clone + 6, function = landmark + 3;
    kept_.clone_pose();
    NewLandmark fresh{.d_pose = random(3, 6), .noise = test::random_covariance(random_, 3, 0.2)};
    fresh.clones = {{.row = static_cast<int>(clone), .d = random(3, 6)}};
    kept_.add({&fresh, 1}, static_cast<int>(landmark));
    const MatrixXd D = random(3, function);
    kept_.append_function(D.transpose());
    MatrixXd M = MatrixXd::Zero(function, clone);
    M.topRows(clone).setIdentity();
    M.block(clone, 0, 6, 6).setIdentity();
    M.block(landmark, 0, 3, 6) = fresh.d_pose + fresh.clones[0].d;
    joint_.transform(M);
    joint_.P.block<3, 3>(landmark, landmark) += fresh.noise;
    MatrixXd with_function(function + 3, function);
    with_function << MatrixXd::Identity(function, function), D;
    joint_.transform(with_function);
  }

  void change_coordinates() {
    const Index n = joint_.n;
    const Eigen::Matrix3d own = Eigen::Matrix3d::Identity() + random(3, 3), other = random(3, 3);
    const int row = static_cast<int>(n) - 3;
    const KeptPast::RowTerm terms[] = {{row, own}, {3, other}};
    kept_.substitute(row, terms);
    MatrixXd M = identity_with(n, row, row, own);
    M.block<3, 3>(row, 3) = other;
    joint_.transform(M);

    const Eigen::Matrix<double, 3, 9> J = random(3, 9);
    const Eigen::Matrix<double, 3, 6> J_camera = random(3, 6);
    const int clone = static_cast<int>(n) - 12;
    kept_.make_cartesian(row, clone, J, 1, J_camera);
    M = identity_with(n, row, clone, J.leftCols<6>());
    M.block<3, 3>(row, row) = J.rightCols<3>();
    M.block<3, 6>(row, 1) += J_camera;
    joint_.transform(M);

    M = MatrixXd::Identity(n, n) + 0.1 * random(n, n);
    kept_.compose({}, M.transpose());
    joint_.transform(M);
  }

  void correct() {
    const Index n = joint_.n;
    const MatrixXd H = random(4, n), R = test::random_covariance(random_, 4, 0.5);
    const VectorXd r = random_.normal_vector(4);
    const MatrixXd P = joint_.P.topLeftCorner(n, n);
    const MatrixXd L = MatrixXd(H * P * H.transpose() + R).llt().matrixL();
    const MatrixXd by_root = L.triangularView<Eigen::Lower>().solve(H).transpose();
    MatrixXd W = P * by_root, kept = kept_.Z() * by_root;
    VectorXd w = L.triangularView<Eigen::Lower>().solve(r);
    using Vectors = Eigen::Map<VectorXd, Eigen::AlignedMax>;
    const Whitened update{.W = W, .kept = kept, .w = Vectors(w.data(), w.size())};
    kept_.correct({}, update, W * w);
    joint_.update(H, R, r);

    const MatrixXd U = random(n, 4), V = 0.1 * random(n, 4);
    kept_.add_outer(U, V);
    joint_.transform(MatrixXd::Identity(n, n) + U * V.transpose());
    const Matrix6d A_clone = Matrix6d::Identity() + random(6, 6);
    const int clone = static_cast<int>(n) - 12;
    kept_.turn_clone(clone, A_clone);
    joint_.transform(identity_with(n, clone, clone, A_clone));
    Matrix6d of_rotation = Matrix6d::Identity();
    of_rotation.bottomLeftCorner<3, 3>() = random(3, 3);
    kept_.add_rotation_of_clone(clone, of_rotation.bottomLeftCorner<3, 3>());
    joint_.transform(identity_with(n, clone, clone, of_rotation));
    const MatrixXd A = MatrixXd::Identity(6, 6) + random(6, 6);
    kept_.turn_motion(A);
    joint_.transform(identity_with(n, 0, 0, A));
    const VectorXd c = 0.1 * random_.normal_vector(n), by = random_.normal_vector(n);
    VectorXd three = VectorXd::Zero(n);
    three.segment<3>(clone) = by.head<3>();
    kept_.add_along(c, clone, by.head<3>());
    joint_.transform(MatrixXd::Identity(n, n) + three * c.transpose());
    kept_.end_correction();
  }

  // A pose, and the landmark; then the state has no more than the core.
  void leave() {
    const Index n = joint_.n;
    const Covariance state = joint_.state();
    const MatrixXd d_core = random(6, kPastCore);
    MatrixXd D = MatrixXd::Zero(6, n);
    D.leftCols(kPastCore) = d_core;
    first_rows_.push_back(joint_.left());
    kept_.remember_pose(Time(number_++), {}, d_core, state);
    joint_.leave(D);

    const Landmark landmark{.id = number_, .row = static_cast<int>(n) - 6};
    first_rows_.push_back(joint_.left());
    kept_.leave(landmark, x_, state);
    kept_.end_leaving(std::array{0}, x_);
    landmarks_.push_back(number_++);
    D = MatrixXd::Zero(3, n);
    D.middleCols<3>(landmark.row).setIdentity();
    joint_.leave(D);

    std::vector<int> rows(kPastCore);
    std::iota(rows.begin(), rows.end(), 0);
    kept_.keep_rows(rows);
    joint_.transform(MatrixXd::Identity(n, n).topRows(kPastCore));
  }

  test::Random random_{3};
  State x_;
  JointGaussian joint_;
  KeptPast kept_;
  int number_ = 0;
  std::vector<int> landmarks_;
  std::vector<Index> first_rows_;
};

TEST(KeptPast, EveryStepIsThatOfTheJointGaussian) {
  LinearSteps steps;
  for (int i = 0; i < 40; ++i) steps.step();  // three segments
  const JointGaussian& joint = steps.joint();
  const Covariance state = joint.state();
  const PastView view = steps.view(state);
  ASSERT_EQ(view.states(), 80);
  EXPECT_EQ(view.map_size(), 40);

  const std::vector<int> numbers{1, 21, 61, 79};
  std::vector<Index> rows;
  for (const int number : numbers) {
    const Index first = joint.n + steps.first_rows()[static_cast<std::size_t>(number)];
    rows.insert(rows.end(), {first, first + 1, first + 2});
  }
  const Carried recalled = view.recall(numbers);
  EXPECT_TRUE(test::agree(recalled.P, joint.P(rows, rows), kJointTolerance, 0));
  const MatrixXd C = joint.P.leftCols(joint.n)(rows, Eigen::all);
  EXPECT_TRUE(test::agree(recalled.C, C, kJointTolerance, 0));
  for (Index& row : rows) row -= joint.n;
  EXPECT_TRUE(test::agree(recalled.correction, joint.correction(rows), kJointTolerance, 1e-12));

  const Past::Estimates all = view.estimates();
  ASSERT_EQ(all.landmarks.size(), 40u);
  ASSERT_EQ(all.poses.size(), 40u);
  for (std::size_t i = 0; i < 40; ++i) {
    const Index pose = steps.first_rows()[2 * i], landmark = steps.first_rows()[2 * i + 1];
    EXPECT_TRUE(test::agree(all.poses[i].covariance,
                            joint.P.block<6, 6>(joint.n + pose, joint.n + pose), kJointTolerance,
                            0));
    EXPECT_TRUE(test::agree(all.poses[i].map_T_imu.p, joint.correction.segment<3>(pose + 3),
                            kJointTolerance, 1e-12));
    EXPECT_TRUE(test::agree(all.landmarks[i].p_world, joint.correction.segment<3>(landmark),
                            kJointTolerance, 1e-12));
    EXPECT_TRUE(test::agree(all.landmarks[i].covariance,
                            joint.P.block<3, 3>(joint.n + landmark, joint.n + landmark),
                            kJointTolerance, 0));
  }
}

// The same run of a filter, with its landmark and a pose of the past.
Ekf some_run(Map map, const std::string& chart) {
  test::Random random(8);
  State x;
  x.v_world = Eigen::Vector3d::Zero();
  x.additive.setZero(6);
  Ekf ekf(error_chart(chart), x, test::random_covariance(random, 15, 0.3),
          {.map = map, .past = {.records = true}});
  for (int i = 0; i < 8; ++i) {
    test::walk_on(ekf, random);
    ekf.remember_pose(Time(i));
    test::add_cartesian(ekf, random, i);
    const std::array z{test::some_measurement(random, 0, 3),
                       test::some_core_measurement(random, 3, 12)};
    ekf.update(z);
    if (i % 2 == 1) ekf.retire(std::array{0});
  }
  return ekf;
}

TEST(KeptPast, WaysOfKeepingItAgree) {
  for (const char* chart : {"left-se3", "right-sen3"}) {
    const Ekf dense = some_run(Map::kDense, chart);
    const Past::Estimates expected = dense.past().estimates();
    ASSERT_EQ(expected.landmarks.size(), 8u);
    for (const Map map : {Map::kHistory, Map::kPast}) {
      const Ekf other = some_run(map, chart);
      EXPECT_EQ(MatrixXd(other.covariance()), MatrixXd(dense.covariance()));
      EXPECT_EQ(other.past().bytes() > 0, map == Map::kHistory) << "no segment has ended";
      const Past::Estimates estimates = other.past().estimates();
      ASSERT_EQ(estimates.landmarks.size(), 8u);
      ASSERT_EQ(estimates.poses.size(), 8u);
      for (std::size_t i = 0; i < 8; ++i) {
        const MapLandmark &one = estimates.landmarks[i], &same = expected.landmarks[i];
        EXPECT_EQ(one.id, same.id);
        EXPECT_TRUE(test::agree(one.p_world, same.p_world, kJointTolerance, 0));
        EXPECT_TRUE(test::agree(one.covariance, same.covariance, kJointTolerance, 0));
        EXPECT_TRUE(test::agree(estimates.poses[i].covariance, expected.poses[i].covariance,
                                kJointTolerance, 0));
      }
    }
  }
}

TEST(KeptPast, FrozenLandmarksStayAsTheyLeft) {
  const MatrixXd P = MatrixXd::Identity(12, 12);
  KeptPast kept(P.topLeftCorner(9, 9), {.map = Map::kFrozen});
  State x;
  const Landmark landmark{.id = 4, .p_world = {1, 2, 3}, .row = 9, .observations = 7};
  x.landmarks = {landmark};
  const Covariance covariance(P);
  kept.leave(landmark, x, covariance);
  kept.end_leaving(std::array{0}, x);
  x.landmarks.clear();
  kept.propagate(2 * MatrixXd::Identity(9, 9), P.topLeftCorner(9, 9), covariance);
  const PastView view(kept, x, covariance);
  ASSERT_EQ(view.map_size(), 1);
  EXPECT_EQ(view.map()[0].p_world, landmark.p_world);
  EXPECT_EQ(view.map()[0].covariance, Eigen::Matrix3d::Identity());
  EXPECT_EQ(view.map()[0].observations, 7);
  EXPECT_EQ(view.bytes(), 0u);
  // A frozen landmark is in world axes, which composition moves.
  const SE3 imu_T_world{so3::exp({0, 0, 0.5}), {4, 5, 6}};
  kept.compose(imu_T_world, MatrixXd::Identity(9, 9));
  EXPECT_EQ(view.map()[0].p_world, imu_T_world * landmark.p_world);
}

TEST(KeptPast, RejectsWhatItsModeDoesNotKeep) {
  const MatrixXd P = MatrixXd::Identity(6, 6);
  const Covariance covariance(P);
  KeptPast steps(P, {.map = Map::kHistory}), frozen(P, {.map = Map::kFrozen}),
      past(P, {.map = Map::kPast});
  EXPECT_THROW(steps.reject_with_history("clones need"), UsageError);
  EXPECT_NO_THROW(past.reject_with_history("clones need"));
  EXPECT_NO_THROW(frozen.reject_with_history("clones need"));
  EXPECT_NO_THROW(steps.remember_pose({}, State{}, covariance));
  EXPECT_THROW(steps.remember_pose({}, {}, P, covariance), UsageError);
  EXPECT_THROW(frozen.remember_pose({}, State{}, covariance), UsageError);
  EXPECT_THROW(frozen.check_can_return({}), UsageError);
  EXPECT_NO_THROW(past.check_can_return({}));
  EXPECT_THROW(past.check_can_return(std::array{0}), UsageError) << "nothing has left";
  EXPECT_THROW(past.add_past({}, covariance), UsageError) << "it does not recall";
  EXPECT_THROW(past.consider({}), UsageError);
}

}  // namespace
}  // namespace chasles
