#include <algorithm>
#include <limits>

#include <Eigen/LU>

#include <chasles/base/error.hpp>
#include <chasles/filter/inertial_testing.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Step of numeric derivatives, limited by an inverse depth of 0.1 1/m.
constexpr double kNumericStep = 3e-4;

using EkfClonesTest = test::OverCharts;
INSTANTIATE_TEST_SUITE_P(Charts, EkfClonesTest, ::testing::ValuesIn(test::all_charts()),
                         test::chart_test_name);

int index_of(const State& x, LandmarkId id) {
  for (std::size_t i = 0; i < x.landmarks.size(); ++i) {
    if (x.landmarks[i].id == id) return static_cast<int>(i);
  }
  return -1;
}

// d p_world of a landmark by all errors of the reference chart.
MatrixXd position_derivative(const State& x, int index) {
  const auto i = static_cast<std::size_t>(index);
  const auto position = [&](const VectorXd& e) -> VectorXd {
    const State y = test::moved(kStandardChart, x, e);
    return y.p_world(y.landmarks[i]);
  };
  return test::numeric_derivative(position, VectorXd::Zero(x.size()), kNumericStep);
}

// The rows of all clones and landmarks match the lists of the state, rise and leave no gap.
void expect_rows_without_gaps(const Ekf& filter) {
  const State& x = filter.state();
  std::vector<std::pair<int, int>> taken;
  for (const Landmark& landmark : x.landmarks) taken.push_back({landmark.row, 3});
  for (const Clone& clone : x.clones) taken.push_back({clone.row, 6});
  for (std::size_t i = 1; i < x.landmarks.size(); ++i) {
    EXPECT_LT(x.landmarks[i - 1].row, x.landmarks[i].row);
  }
  for (std::size_t i = 1; i < x.clones.size(); ++i) {
    EXPECT_LT(x.clones[i - 1].row, x.clones[i].row);
  }
  std::sort(taken.begin(), taken.end());
  int row = x.core_size();
  for (const auto& [first, width] : taken) {
    EXPECT_EQ(first, row);
    row += width;
  }
  EXPECT_EQ(x.size(), row);
  EXPECT_EQ(filter.covariance().rows(), row);
}

// Rows in `before` of all states in `after`, in the order of `after`.
std::vector<int> rows_of_the_same(const State& before, const State& after) {
  std::vector<int> rows(static_cast<std::size_t>(after.size()), -1);
  const auto take = [&](int from, int to, int width) {
    for (int i = 0; i < width; ++i) rows[static_cast<std::size_t>(to + i)] = from + i;
  };
  take(0, 0, after.core_size());
  for (const Clone& clone : after.clones) take(before.clone(clone.id).row, clone.row, 6);
  for (const Landmark& landmark : after.landmarks) {
    const auto index = static_cast<std::size_t>(index_of(before, landmark.id));
    take(before.landmarks[index].row, landmark.row, 3);
  }
  return rows;
}

TEST_P(EkfClonesTest, CloneIsThePoseAgain) {
  test::Random random(1);
  Ekf filter = test::inertial_filter(chart(), random);
  const MatrixXd P = filter.covariance();
  const State before = filter.state();
  filter.clone_pose(9, Time{5});
  const int n = before.size();
  MatrixXd J(n + 6, n);
  J.setIdentity();
  J.block<6, 6>(n, 0).setIdentity();
  EXPECT_EQ(MatrixXd(filter.covariance()), J * P * J.transpose());
  const Clone& clone = filter.state().clones.back();
  EXPECT_EQ(clone.id, 9);
  EXPECT_EQ(clone.time, Time{5});
  EXPECT_EQ(clone.row, n);
  EXPECT_EQ(test::distance(clone.world_T_imu, before.world_T_imu), 0);

  // It is constant, and keeps its correlations.
  const MatrixXd P_cloned = filter.covariance();
  test::walk_on(filter, random);
  EXPECT_EQ(test::distance(clone.world_T_imu, before.world_T_imu), 0);
  const int m = n + 6 - before.core_size();
  EXPECT_EQ(MatrixXd(filter.covariance().bottomRightCorner(m, m)),
            MatrixXd(P_cloned.bottomRightCorner(m, m)));
}

TEST_P(EkfClonesTest, MarginalisedClonesLeaveTheRestAsItWas) {
  test::Random random(2);
  Ekf filter = test::inertial_filter(chart(), random);
  expect_rows_without_gaps(filter);
  filter.make_cartesian(index_of(filter.state(), 101));  // anchored on clone 0
  filter.make_cartesian(index_of(filter.state(), 105));  // on clone 2
  const MatrixXd P = filter.covariance();
  const State before = filter.state();
  const int gone[] = {2, 0};
  filter.remove_clones(gone);
  const State& x = filter.state();
  ASSERT_EQ(x.clones.size(), 1u);
  EXPECT_EQ(x.clones[0].id, 1);
  EXPECT_EQ(x.landmarks.size(), before.landmarks.size());
  expect_rows_without_gaps(filter);
  const std::vector<int> rows = rows_of_the_same(before, x);
  EXPECT_EQ(MatrixXd(filter.covariance()), MatrixXd(P(rows, rows)));
  filter.remove_clones({});
  EXPECT_EQ(filter.state().clones.size(), 1u);
}

TEST_P(EkfClonesTest, RetiredLandmarksKeepWhatTheyHad) {
  test::Random random(3);
  Ekf filter = test::inertial_filter(chart(), random);
  const State before = filter.state();
  const MatrixXd P = filter.covariance();
  const int gone[] = {index_of(before, 102), index_of(before, 103), index_of(before, 105)};
  filter.retire(gone);
  expect_rows_without_gaps(filter);
  const std::vector<int> rows = rows_of_the_same(before, filter.state());
  EXPECT_EQ(MatrixXd(filter.covariance()), MatrixXd(P(rows, rows)));

  // Later updates do not change them, and their clones are not needed.
  filter.update(test::pixel_measurements(filter.state(), random));
  const int unused[] = {1, 2};
  filter.remove_clones(unused);
  expect_rows_without_gaps(filter);
  EXPECT_EQ(filter.map_size(), 6);
  const std::vector<MapLandmark> map = filter.map();
  ASSERT_EQ(map.size(), 6u);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& landmark = before.landmarks[static_cast<std::size_t>(gone[i])];
    const MatrixXd J = position_derivative(before, gone[i]);
    EXPECT_EQ(map[i].id, landmark.id);
    EXPECT_EQ(map[i].p_world, before.p_world(landmark));
    EXPECT_TRUE(test::agree(map[i].covariance, J * P * J.transpose(), 1e-8, 0));
  }
  for (std::size_t i = 3; i < 6; ++i) {
    const MatrixXd J = position_derivative(filter.state(), static_cast<int>(i) - 3);
    EXPECT_TRUE(test::agree(map[i].covariance, J * filter.covariance() * J.transpose(), 1e-8, 0));
  }
}

TEST_P(EkfClonesTest, CartesianFormHasThePositionAndItsCorrelations) {
  test::Random random(4);
  Ekf filter = test::inertial_filter(chart(), random);
  const State before = filter.state();
  const MatrixXd P = filter.covariance();
  const int index = index_of(before, 103);
  const auto i = static_cast<std::size_t>(index);
  MatrixXd J = MatrixXd::Identity(P.rows(), P.cols());
  J.middleRows<3>(before.landmarks[i].row) = position_derivative(before, index);
  filter.make_cartesian(index);
  const Landmark& landmark = filter.state().landmarks[i];
  EXPECT_FALSE(landmark.anchor);
  EXPECT_EQ(landmark.row, before.landmarks[i].row);
  EXPECT_TRUE(test::agree(landmark.p_world, before.p_world(before.landmarks[i]), 1e-15));
  const MatrixXd after = filter.covariance();
  EXPECT_LT(test::covariance_difference(after, J * P * J.transpose()), 1e-8);
  EXPECT_LT(test::covariance_difference(after, after.transpose()), 1e-15);
  filter.make_cartesian(index);  // already Cartesian
  EXPECT_EQ(MatrixXd(filter.covariance()), after);
}

TEST_P(EkfClonesTest, InverseDepthSigmaIsThatOfItsRow) {
  test::Random random(5);
  const Ekf filter = test::inertial_filter(chart(), random);
  const Landmark& landmark =
      filter.state().landmarks[static_cast<std::size_t>(index_of(filter.state(), 101))];
  const int row = landmark.row + 2;
  EXPECT_DOUBLE_EQ(filter.inverse_depth_sigma(landmark), std::sqrt(filter.covariance()(row, row)));
}

TEST_P(EkfClonesTest, LandmarksBeyondInfinityAreNotOfTheMap) {
  test::Random random(11);
  Ekf filter = test::inertial_filter(chart(), random);
  const State before = filter.state();
  const int index = index_of(before, 101);
  const Landmark& anchored = before.landmarks[static_cast<std::size_t>(index)];
  Measurement z;  // moves the inverse depth through zero
  z.landmark = index;
  z.residual = Eigen::VectorXd::Constant(1, -2 * anchored.inverse_depth.z());
  z.d_core = MatrixXd::Zero(1, 6);
  z.d_landmark = Eigen::RowVector3d::UnitZ();
  z.noise = MatrixXd::Constant(1, 1, 1e-12);
  filter.update(std::vector{z});
  const Landmark& beyond = filter.state().landmarks[static_cast<std::size_t>(index)];
  ASSERT_LT(beyond.inverse_depth.z(), 0);
  const auto has_it = [](const std::vector<MapLandmark>& map) {
    return std::ranges::any_of(map, [](const MapLandmark& l) { return l.id == 101; });
  };
  EXPECT_EQ(filter.map_size(), 5);
  EXPECT_EQ(filter.map().size(), 5u);
  EXPECT_FALSE(has_it(filter.map()));
  filter.retire(std::vector{index});
  EXPECT_EQ(filter.map_size(), 5);
  EXPECT_FALSE(has_it(filter.map()));
}

// Measurements of landmarks of both forms, of clones only, and of the core.
std::vector<Measurement> some_measurements(const State& x, test::Random& random) {
  std::vector<Measurement> result = test::pixel_measurements(x, random);
  Measurement of_clones;
  of_clones.residual = 0.02 * random.normal_vector(4);
  of_clones.d_core.resize(4, 0);
  of_clones.noise = test::random_covariance(random, 4, 0.05);
  for (const int id : {0, 2}) {
    MatrixXd d(4, 6);
    for (int j = 0; j < 6; ++j) d.col(j) = random.normal_vector(4);
    of_clones.clones.push_back({.row = x.clone(id).row, .d = d});
  }
  Measurement of_core;
  of_core.core_column = 6;
  of_core.residual = 0.02 * random.normal_vector(3);
  of_core.d_core = Eigen::Matrix3d::Identity();
  of_core.noise = test::random_covariance(random, 3, 0.05);
  result.insert(result.begin() + 4, of_clones);
  result.push_back(of_core);
  return result;
}

// x+ and P+ by definition, in the coordinates of the chart.
TEST_P(EkfClonesTest, UpdateIsTheTextbooksInTheChart) {
  test::Random random(6);
  Ekf filter = test::inertial_filter(chart(), random);
  const State before = filter.state();
  const std::vector<Measurement> measurements = some_measurements(before, random);
  const auto z = test::dense_measurement(before, measurements);
  const MatrixXd T = test::change_of_chart(chart(), before);
  const MatrixXd P = T * filter.covariance() * T.transpose();
  const MatrixXd H = z.H * T.inverse();
  const MatrixXd S = H * P * H.transpose() + z.R;
  const MatrixXd K = P * H.transpose() * S.inverse();
  const State expected = test::moved(chart(), before, K * z.r);
  const MatrixXd I_KH = MatrixXd::Identity(P.rows(), P.cols()) - K * H;
  const MatrixXd P_expected = I_KH * P * I_KH.transpose() + K * z.R * K.transpose();

  const UpdateReport report = filter.update(measurements);
  ASSERT_FALSE(report.failed);
  EXPECT_EQ(report.dof, z.r.size());
  EXPECT_NEAR(report.nis, z.r.dot(S.inverse() * z.r), 1e-9 * report.nis);
  EXPECT_LT(test::distance(filter.state(), expected), 1e-10);
  EXPECT_GT(test::distance(filter.state(), before), 1e-2);
  const MatrixXd T_after = test::change_of_chart(chart(), filter.state());
  const MatrixXd P_after = T_after * filter.covariance() * T_after.transpose();
  EXPECT_LT(test::covariance_difference(P_after, P_expected), 1e-9);
  EXPECT_EQ(MatrixXd(filter.covariance()), MatrixXd(filter.covariance().transpose()));
}

TEST_P(EkfClonesTest, SquaresAreOfTheInnovationAloneAndTogether) {
  test::Random random(7);
  const Ekf filter = test::inertial_filter(chart(), random);
  const std::vector<Measurement> measurements = some_measurements(filter.state(), random);
  const MatrixXd P = filter.covariance();
  const auto square = [&](const std::vector<Measurement>& some) {
    const auto z = test::dense_measurement(filter.state(), some);
    return z.r.dot((z.H * P * z.H.transpose() + z.R).inverse() * z.r);
  };
  const double together = square(measurements);
  EXPECT_NEAR(filter.joint_normalised_square(measurements), together, 1e-9 * together);
  double sum = 0;
  for (const Measurement& one : measurements) {
    const double expected = square({one});
    EXPECT_NEAR(filter.normalised_square(one), expected, 1e-10 * expected);
    sum += expected;
  }
  EXPECT_GT(std::abs(sum - together), 1e-3 * together);
  std::vector<Measurement> impossible = measurements;
  impossible[4].noise = -100 * MatrixXd::Identity(4, 4);
  EXPECT_EQ(filter.joint_normalised_square(impossible), std::numeric_limits<double>::infinity());
}

TEST_P(EkfClonesTest, SquaresGivenAMeasurementOfTheCoreAreThoseAfterIt) {
  test::Random random(8);
  const Ekf filter = test::inertial_filter(chart(), random);
  const std::vector<Measurement> measurements = some_measurements(filter.state(), random);
  Measurement given = measurements.back();
  given.noise *= 0.01;
  const auto first = test::dense_measurement(filter.state(), {given});
  const MatrixXd P = filter.covariance();
  const MatrixXd K =
      P * first.H.transpose() * (first.H * P * first.H.transpose() + first.R).inverse();
  const MatrixXd P_after = P - K * first.H * P;
  const std::vector<double> squares = filter.normalised_squares(measurements, &given);
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    const auto z = test::dense_measurement(filter.state(), {measurements[i]});
    const VectorXd r = z.r - z.H * K * first.r;
    const double expected = r.dot((z.H * P_after * z.H.transpose() + z.R).inverse() * r);
    EXPECT_NEAR(squares[i], expected, 1e-9 * expected) << i;
  }
}

TEST_P(EkfClonesTest, LandmarkMayBeginOnPoseAndClonesTogether) {
  test::Random random(9);
  Ekf filter = test::inertial_filter(chart(), random);
  const MatrixXd P = filter.covariance();
  const State before = filter.state();
  std::vector<NewLandmark> fresh(2);
  MatrixXd J = MatrixXd::Zero(6, P.cols());
  MatrixXd noise = MatrixXd::Zero(6, 6);
  for (int i = 0; i < 2; ++i) {
    NewLandmark& one = fresh[static_cast<std::size_t>(i)];
    for (int j = 0; j < 6; ++j) one.d_pose.col(j) = random.normal_vector(3);
    J.block<3, 6>(3 * i, 0) = one.d_pose;
    for (int id = i; id < 3; ++id) {
      Eigen::Matrix<double, 3, 6> d;
      for (int j = 0; j < 6; ++j) d.col(j) = random.normal_vector(3);
      const int row = before.clone(id).row;
      one.clones.push_back({.row = row, .d = d});
      J.block<3, 6>(3 * i, row) = d;
    }
    one.noise = test::random_covariance(random, 3, 0.1);
    noise.block<3, 3>(3 * i, 3 * i) = one.noise;
  }
  filter.add(fresh);
  MatrixXd expected(P.rows() + 6, P.rows() + 6);
  expected << P, P * J.transpose(), J * P, J * P * J.transpose() + noise;
  EXPECT_LT(test::covariance_difference(filter.covariance(), expected), 1e-13);
  expect_rows_without_gaps(filter);
}

TEST(EkfClones, AreRejectedWhereTheWholeMapIsKept) {
  State x;
  x.nav_T_world = SE3{};
  x.additive.resize(0);
  Ekf filter(kStandardChart, x, MatrixXd::Identity(12, 12), {});
  EXPECT_THROW(filter.clone_pose(1, Time{}), UsageError);
  EXPECT_THROW(filter.compose(), UsageError);
}

}  // namespace
}  // namespace chasles
