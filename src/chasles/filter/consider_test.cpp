#include <array>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

#include <Eigen/LU>

#include <chasles/base/error.hpp>
#include <chasles/filter/inertial_testing.hpp>
#include <chasles/filter/random_ekf_testing.hpp>
#include <chasles/lie/so3.hpp>

// A considered map against the Schmidt-Kalman filter of the textbooks: the gain of what is
// considered is zero, in coordinates in which it is a part of the state, and the covariance follows
// from Joseph's form.

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kShared = 5, kOfFrame = 2, kLandmarks = 6;

PriorMap random_map(test::Random& random) {
  PriorMap prior{.map_T_prior = test::random_pose(random, 5),
                 .landmarks = {},
                 .shared = 0.1 * test::random_matrix(random, 6 + 3 * kLandmarks, kShared),
                 .own = {},
                 .of_frame = kOfFrame};
  for (int i = 0; i < kLandmarks; ++i) {
    const Vector3d p = 8 * random.axis();
    prior.landmarks.push_back({.id = 5000 + i, .p_world = p, .observations = 20, .first = p});
    prior.own.emplace_back(test::random_covariance(random, 3, 0.05));
  }
  return prior;
}

Ekf filter_with_past(const ErrorChart& chart, test::Random& random, bool nav,
                     const std::vector<int>& considered = {}) {
  return test::inertial_filter(chart, random, nav, false,
                               {.map = Ekf::Map::kPast,
                                .past = {.recalls = true, .records = true},
                                .considered = considered});
}

// From the errors of the state to the same with the own error of each landmark of the map, in nav
// axes, in the place of the landmark's.
MatrixXd to_own_errors(const State& x, const PriorMap& prior) {
  MatrixXd T = MatrixXd::Identity(x.size(), x.size());
  const auto put = [&](const Landmark& landmark, const MatrixXd& by_state) {
    T.middleRows<3>(landmark.row) = by_state;
    T.block(landmark.row, x.considered->row, 3, kShared) -=
        prior.shared.middleRows<3>(6 + 3 * (*landmark.considered - x.considered->frame - 1));
  };
  for (const Landmark& landmark : x.landmarks) {
    if (!landmark.considered) continue;
    MatrixXd d = MatrixXd::Zero(3, x.size());
    const Eigen::Matrix3d R = x.nav_T_world ? x.nav_T_world->R : Eigen::Matrix3d::Identity();
    d.middleCols<3>(landmark.row) = R;
    if (x.nav_T_world) {
      d.middleCols<3>(x.nav_row()) = -hat(R * landmark.p_world);
      d.middleCols<3>(x.nav_row() + 3).setIdentity();
    }
    put(landmark, d);
  }
  for (const Landmark& landmark : x.considered->away) {
    MatrixXd d = MatrixXd::Zero(3, x.size());
    d.middleCols<3>(landmark.row).setIdentity();
    put(landmark, d);
  }
  return T;
}

std::vector<int> rows_of_the_map(const State& x) {
  std::vector<int> rows(kShared - kOfFrame);
  std::iota(rows.begin(), rows.end(), x.considered->row);
  const auto add = [&](const Landmark& landmark) {
    for (int k = 0; k < 3; ++k) rows.push_back(landmark.row + k);
  };
  for (const Landmark& landmark : x.landmarks) {
    if (landmark.considered) add(landmark);
  }
  for (const Landmark& landmark : x.considered->away) add(landmark);
  return rows;
}

class ConsiderTest : public ::testing::TestWithParam<std::tuple<bool, bool>> {};
INSTANTIATE_TEST_SUITE_P(Axes, ConsiderTest,
                         ::testing::Combine(::testing::Bool(), ::testing::Bool()),
                         [](const auto& info) {
                           return std::string(std::get<0>(info.param) ? "nav" : "world") +
                                  (std::get<1>(info.param) ? "WithRowsOfTheCore" : "");
                         });

TEST_P(ConsiderTest, IsTheSchmidtKalmanFilter) {
  test::Random random(3);
  const auto [nav, rows_too] = GetParam();
  const int biases = nav ? 15 : 9;
  const std::vector<int> considered =
      rows_too ? std::vector{biases, biases + 2, biases + 5} : std::vector<int>{};
  Ekf ekf = filter_with_past(kStandardChart, random, nav, considered);
  const PriorMap prior = random_map(random);
  const int frame = ekf.consider(prior);
  ekf.revive(std::array{frame + 1, frame + 3, frame + 4, frame + 6});
  ekf.retire(std::array{static_cast<int>(ekf.state().landmarks.size()) - 2});
  for (int step = 0; step < 5; ++step) {
    SCOPED_TRACE(step);
    const State& x = ekf.state();
    ASSERT_EQ(x.considered->away.size(), 1u);
    std::vector<Measurement> measurements;
    const auto last = static_cast<int>(x.landmarks.size()) - 1;
    for (const int landmark : {last, last - 1, last - 2, 0}) {
      measurements.push_back(test::some_measurement(random, landmark, 2));
      measurements.back().residual *= 1e-4;  // so that the mean stays where it is linearised
    }
    const auto m = static_cast<Index>(2 * measurements.size());
    MatrixXd H = MatrixXd::Zero(m, x.size()), R = MatrixXd::Zero(m, m);
    VectorXd r(m);
    for (std::size_t i = 0; i < measurements.size(); ++i) {
      const Measurement& z = measurements[i];
      const auto at = static_cast<Index>(2 * i);
      const Landmark& landmark = x.landmarks[static_cast<std::size_t>(z.landmark)];
      H.block(at, z.core_column, 2, z.d_core.cols()) = z.d_core;
      H.block<2, 3>(at, landmark.row) = z.d_landmark;
      R.block<2, 2>(at, at) = z.noise;
      r.segment<2>(at) = z.residual;
    }
    const MatrixXd T = to_own_errors(x, prior), P = T * ekf.covariance() * T.transpose();
    H = H * T.inverse();
    MatrixXd K = P * H.transpose() * (H * P * H.transpose() + R).inverse();
    K(rows_of_the_map(x), Eigen::all).setZero();
    K(considered, Eigen::all).setZero();
    const MatrixXd I = MatrixXd::Identity(x.size(), x.size());
    const MatrixXd expected = (I - K * H) * P * (I - K * H).transpose() + K * R * K.transpose();
    const VectorXd frame_before = x.considered->mean;
    ekf.update(measurements);
    const MatrixXd updated = T * ekf.covariance() * T.transpose();
    EXPECT_LT(test::covariance_difference(updated, expected), 1e-9);
    EXPECT_TRUE(test::agree(x.considered->mean - frame_before,
                            (K * r).segment(x.considered->row, kShared), 1e-9, 1e-15));
    test::walk_on(ekf, random);
    if (nav) ekf.compose();
  }
}

// In every chart, however often its landmarks leave and return.
TEST(Consider, TheMapIsNotChanged) {
  for (const ErrorChart& chart : error_charts()) {
    SCOPED_TRACE(chart.name);
    test::Random random(4);
    Ekf ekf = filter_with_past(chart, random, false);
    const PriorMap prior = random_map(random);
    const int frame = ekf.consider(prior);
    std::vector<int> numbers{frame};
    for (int i = 1; i <= kLandmarks; ++i) numbers.push_back(frame + i);
    for (int step = 0; step < 12; ++step) {
      const auto before = static_cast<int>(ekf.state().landmarks.size());
      const int of_map = frame + 1 + step % kLandmarks;
      ekf.revive(std::array{of_map});
      const Measurement measurements[] = {test::some_measurement(random, before, 2),
                                          test::some_measurement(random, 0, 2)};
      ekf.update(measurements);
      const State& x = ekf.state();
      const Vector3d expected =
          prior.landmarks[static_cast<std::size_t>(of_map - frame - 1)].p_world +
          prior.shared.block<3, kOfFrame>(6 + 3 * (of_map - frame - 1), kShared - kOfFrame) *
              x.considered->mean.tail<kOfFrame>();
      EXPECT_LT((x.landmarks.back().p_world - expected).norm(), 1e-12);
      EXPECT_EQ(x.considered->mean.head<kShared - kOfFrame>().norm(), 0);
      EXPECT_GT(x.considered->mean.norm(), 1e-3) << "its frame is corrected";
      ekf.retire(std::array{before});
      test::walk_on(ekf, random);
    }
    const Carried all = ekf.past().recall(numbers);
    ASSERT_EQ(all.items.size(), numbers.size());
    const int fixed = kShared - kOfFrame;
    EXPECT_TRUE(test::agree(all.P.topLeftCorner(fixed, fixed), MatrixXd::Identity(fixed, fixed),
                            1e-12, 1e-12));
    EXPECT_LT(all.P.block(fixed, fixed, kOfFrame, kOfFrame).trace(), 0.9 * kOfFrame);
  }
}

// What is taken from the map's landmarks is less than if they were estimated, and than if they were
// exact, which no covariance of a map is.
TEST(Consider, ItsUncertaintyCounts) {
  test::Random random(5), same(5), exact_random(5);
  Ekf considers = filter_with_past(kStandardChart, random, false),
      estimates = filter_with_past(kStandardChart, same, false),
      trusts = filter_with_past(kStandardChart, exact_random, false);
  const PriorMap prior = random_map(random);
  PriorMap exact = prior;
  exact.shared.leftCols(kShared - kOfFrame).setZero();
  for (auto& own : exact.own) own.setZero();
  const int frames[] = {considers.consider(prior), estimates.add_past(prior),
                        trusts.add_past(exact)};
  Ekf* filters[] = {&considers, &estimates, &trusts};
  for (int i = 0; i < 3; ++i) filters[i]->revive(std::array{frames[i] + 1, frames[i] + 2});
  for (int step = 0; step < 10; ++step) {
    const auto last = static_cast<int>(considers.state().landmarks.size()) - 1;
    const Measurement measurements[] = {test::some_measurement(random, last, 2),
                                        test::some_measurement(random, last - 1, 2)};
    for (Ekf* filter : filters) filter->update(measurements);
  }
  const auto of_pose = [](const Ekf& ekf) {
    return ekf.covariance().topLeftCorner<6, 6>().trace();
  };
  EXPECT_LT(of_pose(trusts), of_pose(estimates));
  EXPECT_LT(of_pose(estimates), of_pose(considers));
}

TEST(Consider, BadCallsAreErrors) {
  test::Random random(6);
  Ekf ekf = filter_with_past(kStandardChart, random, false);
  PriorMap wrong = random_map(random);
  wrong.own.pop_back();
  EXPECT_THROW(ekf.consider(wrong), UsageError);
  const int frame = ekf.consider(random_map(random));
  EXPECT_THROW(ekf.consider(random_map(random)), UsageError) << "a second map";
  EXPECT_THROW(ekf.revive(std::array{frame}), UsageError) << "a frame is no landmark";
  ekf.revive(std::array{frame + 1});
  EXPECT_THROW(ekf.revive(std::array{frame + 1}), UsageError) << "it is in the state";
  ekf.retire(std::array{static_cast<int>(ekf.state().landmarks.size()) - 1});
  const Eigen::Index rows = ekf.covariance().rows();
  ekf.bar_return(std::array{frame + 1});
  EXPECT_EQ(ekf.covariance().rows(), rows - 3);
  EXPECT_THROW(ekf.revive(std::array{frame + 1}), UsageError) << "it is marginalised";
  Ekf frozen = test::inertial_filter(kStandardChart, random, false, false);
  EXPECT_THROW(frozen.consider(random_map(random)), UsageError);
}

}  // namespace
}  // namespace chasles
