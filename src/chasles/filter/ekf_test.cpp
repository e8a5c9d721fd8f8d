#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <chasles/filter/ekf.hpp>
#include <chasles/filter/random_ekf_testing.hpp>
#include <chasles/filter/run_drive_testing.hpp>
#include <chasles/filter/testing.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using namespace test;

using EkfTest = test::OverCharts;
INSTANTIATE_TEST_SUITE_P(Charts, EkfTest, ::testing::ValuesIn(test::all_charts()),
                         test::chart_test_name);

// Up to round-off: a failed update copies one triangle of the covariance from the other.
void expect_unchanged(const Ekf& ekf, const Ekf& before) {
  EXPECT_EQ(test::distance(ekf.state(), before.state()), 0);
  EXPECT_TRUE(test::agree(ekf.covariance(), before.covariance(), 1e-15));
  const auto map = ekf.map();
  const auto map_before = before.map();
  ASSERT_EQ(map.size(), map_before.size());
  for (std::size_t i = 0; i < map.size(); ++i) {
    EXPECT_EQ(map[i].observations, map_before[i].observations);
  }
}

TEST_P(EkfTest, UpdateIsKalmansInTheCoordinatesOfTheChart) {
  test::Random random(1);
  for (const bool many : {false, true}) {
    SCOPED_TRACE(many);
    Ekf ekf = some_filter(chart(), random, many ? 30 : 4);
    const std::vector<Measurement> measurements =
        many ? many_measurements(random, 30) : some_measurements(random);
    const State before = ekf.state();
    const MatrixXd P = ekf.covariance();
    const DenseMeasurement z = dense_measurement(ekf.state(), measurements);
    const MatrixXd S = innovation(ekf, z);
    const MatrixXd K = P * z.H.transpose() * S.inverse();
    const MatrixXd I_KH = MatrixXd::Identity(P.rows(), P.cols()) - K * z.H;
    MatrixXd expected = I_KH * P * I_KH.transpose() + K * z.R * K.transpose();
    VectorXd xi = K * z.r;
    push(chart(), before, xi);

    const UpdateReport report = ekf.update(measurements);
    EXPECT_FALSE(report.failed);
    EXPECT_LT(test::distance(ekf.state(), test::moved(chart(), before, xi)), 1e-12);
    MatrixXd actual = ekf.covariance();
    EXPECT_TRUE(actual == actual.transpose());
    for (MatrixXd* M : {&actual, &expected}) {  // both in chart coordinates
      const State& at = M == &actual ? ekf.state() : before;
      push(chart(), at, *M);
      M->transposeInPlace();
      push(chart(), at, *M);
    }
    EXPECT_LT(test::covariance_difference(actual, expected), 1e-11);
    EXPECT_EQ(report.dof, z.r.size());
    EXPECT_NEAR(report.nis, z.r.dot(S.inverse() * z.r), 1e-10 * report.nis);
  }
}

TEST_P(EkfTest, NisIsTheSquareOfTheInnovationByItsInverseCovariance) {
  test::Random random(2);
  Ekf ekf = some_filter(chart(), random, 3);
  const std::vector<Measurement> measurements = some_measurements(random);
  const DenseMeasurement z = dense_measurement(ekf.state(), measurements);
  const double expected = z.r.dot(innovation(ekf, z).inverse() * z.r);
  for (const Measurement& one : measurements) {
    const DenseMeasurement single = dense_measurement(ekf.state(), {one});
    const double square = single.r.dot(innovation(ekf, single).inverse() * single.r);
    EXPECT_NEAR(ekf.normalised_square(one), square, 1e-11 * square);
  }
  const UpdateReport report = ekf.update(measurements);
  EXPECT_NEAR(report.nis, expected, 1e-10 * expected);
  EXPECT_EQ(report.dof, z.r.size());
}

TEST_P(EkfTest, GateRejectsExactlyTheSquaresAboveIt) {
  test::Random random(3);
  const Ekf ekf = some_filter(chart(), random, 3);
  for (const double shared : {0.0, 0.5}) {  // part of the noise that the gate leaves out
    std::vector<Measurement> measurements = some_measurements(random);
    std::vector<Measurement> inside;
    std::vector<bool> expected;
    for (std::size_t i = 0; i < measurements.size(); ++i) {
      Measurement& m = measurements[i];
      const DenseMeasurement z = dense_measurement(ekf.state(), {m});
      m.shared_variance = shared / MatrixXd(m.noise).inverse().norm();
      MatrixXd S = innovation(ekf, z);
      S.diagonal().array() -= m.shared_variance;
      const double square = z.r.dot(S.inverse() * z.r);
      expected.push_back(i % 2 == 0);
      m.gate = square * (i % 2 == 0 ? 1 + 1e-9 : 1 - 1e-9);
      if (i % 2 == 0) inside.push_back(m);
    }
    Ekf gated = ekf;
    Ekf chosen = ekf;
    EXPECT_EQ(gated.update(measurements).accepted, expected);
    chosen.update(inside);
    EXPECT_EQ(test::distance(gated.state(), chosen.state()), 0);
    EXPECT_EQ(MatrixXd(gated.covariance()), MatrixXd(chosen.covariance()));
  }
}

TEST_P(EkfTest, SquaresGivenAMeasurementAreThoseAfterIt) {
  test::Random random(12);
  const Ekf ekf = some_filter(chart(), random, 3);
  const std::vector<Measurement> measurements = some_measurements(random);
  Measurement given = some_core_measurement(random, 9, 6);
  given.noise *= 0.01;
  const DenseMeasurement first = dense_measurement(ekf.state(), {given});
  const MatrixXd P = ekf.covariance();
  const MatrixXd K = P * first.H.transpose() * innovation(ekf, first).inverse();
  const MatrixXd P_after = P - K * first.H * P;
  const std::vector<double> alone = ekf.normalised_squares(measurements, nullptr);
  const std::vector<double> after = ekf.normalised_squares(measurements, &given);
  ASSERT_EQ(after.size(), measurements.size());
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    const DenseMeasurement z = dense_measurement(ekf.state(), {measurements[i]});
    const VectorXd r = z.r - z.H * K * first.r;
    const double expected = r.dot((z.H * P_after * z.H.transpose() + z.R).inverse() * r);
    EXPECT_NEAR(after[i], expected, 1e-9 * expected);
    EXPECT_EQ(alone[i], ekf.normalised_square(measurements[i]));
  }
}

TEST_P(EkfTest, NothingThatIsNotANumberComesIn) {
  test::Random random(4);
  const Ekf before = some_filter(chart(), random, 3);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const double gate : {9.0, std::numeric_limits<double>::infinity()}) {
    SCOPED_TRACE(gate);
    std::vector<Measurement> bad(4, some_measurement(random, 1, 3));
    bad[0].residual[1] = kNan;
    bad[1].d_core(0, 2) = kNan;
    bad[2].d_landmark(2, 2) = kNan;
    bad[3].noise(1, 1) = kNan;
    for (Measurement& z : bad) {
      z.gate = gate;
      Ekf ekf = before;
      EXPECT_EQ(ekf.update(std::vector<Measurement>{z}).dof, 0);
      expect_unchanged(ekf, before);
    }
    // A residual that is not finite does not prevent the update by the others.
    bad[1] = some_measurement(random, 2, 3);
    bad.resize(2);
    Ekf ekf = before;
    EXPECT_EQ(ekf.update(bad).accepted, (std::vector<bool>{false, true}));
    EXPECT_TRUE(ekf.covariance().allFinite());
  }
}

TEST_P(EkfTest, InnovationThatIsNotPositiveDefiniteFailsAndChangesNothing) {
  test::Random random(5);
  const Ekf before = some_filter(chart(), random, 30);
  Ekf ekf = before;
  for (const bool many : {false, true}) {
    std::vector<Measurement> measurements =
        many ? many_measurements(random, 30) : some_measurements(random);
    measurements.push_back(some_measurement(random, 1, 4));
    measurements.back().noise = -100 * MatrixXd::Identity(4, 4);
    const UpdateReport report = ekf.update(measurements);
    EXPECT_TRUE(report.failed);
    EXPECT_EQ(report.dof, 0);
    expect_unchanged(ekf, before);
  }
  // The map does not contain it either.
  Ekf clean = before;
  const int indices[] = {0, 1};
  for (Ekf* filter : {&ekf, &clean}) {
    test::Random same(55);
    filter->update(some_measurements(same));
    filter->retire(indices);
  }
  EXPECT_TRUE(test::agree(ekf.map()[0].p_world, clean.map()[0].p_world, 1e-14));
  EXPECT_TRUE(test::agree(test::whole_covariance(ekf), test::whole_covariance(clean), 1e-14));
}

TEST_P(EkfTest, NothingToDoChangesNothing) {
  test::Random random(6);
  const Ekf before = some_filter(chart(), random, 3);
  Ekf ekf = before;
  const UpdateReport report = ekf.update({});
  EXPECT_EQ(report.dof, 0);
  EXPECT_FALSE(report.failed);
  EXPECT_TRUE(report.accepted.empty());
  ekf.add({});
  ekf.retire({});
  expect_unchanged(ekf, before);
}

TEST_P(EkfTest, UpdateCountsTheObservationsThatItUsed) {
  test::Random random(7);
  Ekf ekf = some_filter(chart(), random, 3);
  std::vector<Measurement> measurements = {some_measurement(random, 0, 3),
                                           some_measurement(random, 2, 3),
                                           some_measurement(random, 2, 3)};
  measurements[0].gate = 0;
  ekf.update(measurements);
  EXPECT_EQ(ekf.state().landmarks[0].observations, 1);
  EXPECT_EQ(ekf.state().landmarks[1].observations, 1);
  EXPECT_EQ(ekf.state().landmarks[2].observations, 3);
}

TEST_P(EkfTest, PropagationMovesTheCoreAndItsTiesToTheLandmarks) {
  test::Random random(8);
  Ekf ekf = some_filter(chart(), random, 3);
  const MatrixXd P = ekf.covariance();
  const std::vector<Landmark> landmarks = ekf.state().landmarks;
  Prediction step{.world_T_imu = test::random_pose(random, 5),
                  .v_world = Eigen::Vector3d(1, 2, 3),
                  .additive = random.normal_vector(6),
                  .F = random_matrix(random, 15, 15),
                  .Q = test::random_covariance(random, 15, 0.1)};
  ekf.propagate(step);
  MatrixXd F = MatrixXd::Identity(P.rows(), P.rows());
  F.topLeftCorner<15, 15>() = step.F;
  MatrixXd expected = F * P * F.transpose();
  expected.topLeftCorner<15, 15>() += step.Q;
  EXPECT_TRUE(test::agree(ekf.covariance(), expected, 1e-13));
  EXPECT_TRUE(test::agree(ekf.state().world_T_imu.R, step.world_T_imu.R, 1e-15));
  EXPECT_EQ(ekf.state().world_T_imu.p, step.world_T_imu.p);
  EXPECT_EQ(*ekf.state().v_world, *step.v_world);
  EXPECT_EQ(ekf.state().additive, step.additive);
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    EXPECT_EQ(ekf.state().landmarks[i].p_world, landmarks[i].p_world);
  }
}

TEST_P(EkfTest, RotationStaysOneWhateverRoundOffBringsIn) {
  test::Random random(13);
  Ekf ekf = some_filter(chart(), random, 2);
  Prediction step{.world_T_imu = ekf.state().world_T_imu,
                  .v_world = ekf.state().v_world,
                  .additive = ekf.state().additive,
                  .F = MatrixXd::Identity(15, 15),
                  .Q = MatrixXd::Zero(15, 15)};
  step.world_T_imu.R += 1e-9 * random_matrix(random, 3, 3);
  ekf.propagate(step);
  const auto rotation = [&] { return ekf.state().world_T_imu.R; };
  EXPECT_TRUE(test::agree(rotation() * rotation().transpose(), Eigen::Matrix3d::Identity(), 2e-15));
  for (int i = 0; i < 1000; ++i) {
    ekf.update(std::vector<Measurement>{some_measurement(random, 1, 3)});
  }
  EXPECT_TRUE(test::agree(rotation() * rotation().transpose(), Eigen::Matrix3d::Identity(), 2e-15));
}

TEST_P(EkfTest, NewLandmarksKnowOfEachOtherThroughThePose) {
  test::Random random(9);
  Ekf ekf = some_filter(chart(), random, 2);
  const MatrixXd P = ekf.covariance();
  std::vector<NewLandmark> fresh;
  MatrixXd J = MatrixXd::Zero(6, P.rows());
  MatrixXd noise = MatrixXd::Zero(6, 6);
  for (int i = 0; i < 2; ++i) {
    fresh.push_back({.id = i,
                     .p_world = random.normal_vector(3),
                     .d_pose = random_matrix(random, 3, 6),
                     .noise = test::random_covariance(random, 3, 0.2)});
    J.block<3, 6>(3 * i, 0) = fresh.back().d_pose;
    noise.block<3, 3>(3 * i, 3 * i) = fresh.back().noise;
  }
  ekf.add(fresh);
  MatrixXd expected(P.rows() + 6, P.rows() + 6);
  expected << P, P * J.transpose(), J * P, J * P * J.transpose() + noise;
  EXPECT_TRUE(test::agree(ekf.covariance(), expected, 1e-13));
  ASSERT_EQ(ekf.state().landmarks.size(), 4u);
  EXPECT_EQ(ekf.state().landmarks[3].id, 1);
  EXPECT_EQ(ekf.state().landmarks[3].row, 24);
  EXPECT_EQ(ekf.state().landmarks[3].p_world, fresh[1].p_world);
}

TEST_P(EkfTest, RetiringLeavesTheOthersAsTheyWere) {
  test::Random random(10);
  Ekf ekf = some_filter(chart(), random, 5);
  const MatrixXd P = ekf.covariance();
  const State before = ekf.state();
  const int gone[] = {1, 3};
  ekf.retire(gone);
  std::vector<int> rows;
  for (int i = 0; i < 30; ++i) {
    if ((i < 18 || i >= 21) && (i < 24 || i >= 27)) rows.push_back(i);
  }
  EXPECT_EQ(MatrixXd(ekf.covariance()), MatrixXd(P(rows, rows)));
  ASSERT_EQ(ekf.state().landmarks.size(), 3u);
  EXPECT_EQ(ekf.state().landmarks[1].id, before.landmarks[2].id);
  EXPECT_EQ(ekf.state().landmarks[2].row, 21);
  EXPECT_EQ(ekf.map_size(), 5);
  const std::vector<MapLandmark> map = ekf.map();
  EXPECT_EQ(map[0].id, before.landmarks[1].id);
  EXPECT_TRUE(test::agree(map[1].p_world, before.landmarks[3].p_world, 1e-14));
  EXPECT_TRUE(test::agree(map[1].covariance, P.block(24, 24, 3, 3), 1e-12));
}

TEST_P(EkfTest, CovarianceStaysSymmetricAndPositiveDefiniteThroughADrive) {
  const test::Drive drive = test::simulate_drive({.frames = 120,
                                                  .initial_points = 10,
                                                  .points_a_frame = 1,
                                                  .outlier_share = 0.02,
                                                  .seed = 21});
  for (const test::Motion motion :
       {test::Motion::kVelocityState, test::Motion::kVelocityInput, test::Motion::kInertial}) {
    SCOPED_TRACE(test::motion_test_name(motion));
    test::DrivenFilter filter(chart(), drive, {.motion = motion, .gate = 11.34},
                              test::initial_covariance(motion, 0.05), Ekf::Map::kHistory);
    for (std::size_t i = 0; i < drive.frames.size(); ++i) {
      filter.step();
      const MatrixXd P = filter.ekf().covariance();
      ASSERT_LT(test::covariance_difference(P, P.transpose()), 1e-13) << i;
      ASSERT_EQ(P.llt().info(), Eigen::Success) << i;
    }
    // A few metres over a distance of 96 m.
    EXPECT_LT((filter.ekf().state().world_T_imu.p - drive.frames.back().world_T_imu.p).norm(), 5);
  }
}

}  // namespace
}  // namespace chasles
