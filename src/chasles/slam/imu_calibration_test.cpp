#include <cmath>

#include <gtest/gtest.h>

#include <chasles/eval/chi2.hpp>
#include <chasles/eval/nees.hpp>
#include <chasles/filter/charts/error_chart.hpp>
#include <chasles/imu/imu_correction_testing.hpp>
#include <chasles/initialise/static_start.hpp>
#include <chasles/numeric/random.hpp>
#include <chasles/slam/calibration_testing.hpp>
#include <chasles/slam/initial_filter.hpp>
#include <chasles/slam/start_by_imu.hpp>
#include <chasles/slam/state_predictor.hpp>

// Estimation of the IMU's scales, misalignments and g-sensitivity on simulated recordings.

namespace chasles {
namespace {

using namespace test;

InertialSlamSettings with_imu(Calibrate use) {
  InertialSlamSettings settings;
  settings.calibrate_imu = use;
  return settings;
}

// Errors drawn by the sigmas of the settings.
ImuCorrection drawn_errors(const InertialSlamSettings& settings, std::uint64_t run) {
  ImuCorrection errors;
  Eigen::VectorXd parameters = imu_sigmas(settings, errors);
  const chasles::Random random = random_of_run(78, run);
  for (Eigen::Index i = 0; i < parameters.size(); ++i) {
    parameters[i] *= random.normal(Stream::kStart, 1, static_cast<std::uint32_t>(i));
  }
  errors.add(parameters);
  return errors;
}

Recording recorded_with(const ImuCorrection& errors, Recording recording) {
  for (ImuSample& sample : recording.imu) sample = as_measured(errors, sample);
  return recording;
}

double nees_of(const ImuCorrection& truth, const Calibration& found) {
  const int n = found.imu->size();
  return normalised_square(truth.parameters() - found.imu->parameters(),
                           found.covariance.bottomRightCorner(n, n));
}

// Means over runs of a walk that shakes about all axes.
struct ImuScore {
  double ate = 0, pose_nees = 0, state_nees = 0, parameter_nees = 0;

  void add(const Trial& trial, double runs) {
    EXPECT_FALSE(trial.diverged);
    ate += averages(trial).ate_posyaw / runs;
    pose_nees += trial.points.back().nees_pose / 6 / runs;
    state_nees += trial.points.back().nees_state / 15 / runs;
  }
};

TEST(ImuCalibration, IsEstimatedOrConsideredConsistently) {
  constexpr std::uint64_t kRuns = 20;
  const InertialScene scene = shaken(1);
  const auto known = with_imu(Calibrate::kFalse);
  ImuScore exact, wrong, considered, estimated;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const Recording right = simulate_inertial(scene, run);
    const ImuCorrection errors = drawn_errors(known, run);
    const Recording recording = recorded_with(errors, right);
    const auto trial = [&](const Recording& of, const InertialSlamSettings& settings) {
      return run_trial({.name = "", .settings = settings}, of, draw_start(of, settings, 1, run));
    };
    exact.add(trial(right, known), kRuns);
    wrong.add(trial(recording, known), kRuns);
    const Trial unmoved = trial(recording, with_imu(Calibrate::kConsidered));
    considered.add(unmoved, kRuns);
    ASSERT_TRUE(unmoved.calibration && unmoved.calibration->imu);
    EXPECT_TRUE(unmoved.calibration->imu->parameters().isZero(0));
    EXPECT_TRUE(test::agree(Eigen::VectorXd(unmoved.calibration->covariance.diagonal()),
                            Eigen::VectorXd(imu_sigmas(known, errors).cwiseAbs2()), 1e-9));
    const Trial found = trial(recording, with_imu(Calibrate::kTrue));
    estimated.add(found, kRuns);
    estimated.parameter_nees += nees_of(errors, *found.calibration);
  }
  const double dof = 24 * static_cast<double>(kRuns);
  EXPECT_GT(estimated.parameter_nees, chi2_quantile(0.0005, dof));
  EXPECT_LT(estimated.parameter_nees, chi2_quantile(0.9995, dof));
  for (const ImuScore& one : {considered, estimated}) {
    EXPECT_GT(one.pose_nees, 0.6);
    EXPECT_LT(one.pose_nees, 1.6);
    EXPECT_LT(one.state_nees, 1.6);
  }
  EXPECT_GT(wrong.pose_nees, 2);
  EXPECT_LT(estimated.ate, 1.2 * exact.ate);
}

// In each chart, with the transitions of the papers, composition, first estimates, and beside a
// time offset.
TEST(ImuCalibration, GoesWithEveryChart) {
  const Recording right = simulate_inertial(shaken(1), 4);
  const ImuCorrection errors = drawn_errors({}, 4);
  const Recording recording = recorded_with(errors, right);
  const auto nees = [&](const InertialSlamSettings& settings) {
    const Trial trial = run_trial({.name = "", .settings = settings}, recording,
                                  draw_start(recording, settings, 1, 4));
    EXPECT_FALSE(trial.diverged);
    EXPECT_LT(averages(trial).ate_posyaw, 0.1);
    return nees_of(errors, *trial.calibration);
  };
  for (const ErrorChart& chart : error_charts()) {
    InertialSlamSettings settings = with_imu(Calibrate::kTrue);
    settings.chart = chart.name;
    settings.nav_attitude = settings.first_order_transition = chart.name != kRightSen3Chart.name;
    settings.composition_interval = settings.nav_attitude ? 0.5 : 0;
    settings.calibrate_time_offset = Calibrate::kTrue;
    EXPECT_LT(nees(settings), chi2_quantile(0.9995, 24)) << chart.name;
  }
  InertialSlamSettings settings = with_imu(Calibrate::kTrue);
  settings.chart = "standard";
  settings.first_estimates = Toggle::kTrue;
  EXPECT_LT(nees(settings), chi2_quantile(0.9995, 24));
}

// The start of corrected samples differs from that of measured ones by its derivative.
TEST(StartByImu, IsTheDerivativeOfAStaticStart) {
  test::Random random(1);
  const InertialSlamSettings settings = with_imu(Calibrate::kTrue);
  Calibration calibration = *stated_calibration(settings, {});
  const ImuNoise noise{.accelerometer_noise_density = 1e-4, .gyroscope_noise_density = 1e-6};
  for (int k = 0; k < 5; ++k) {
    const Eigen::Vector3d axis = random.axis();
    StandstillMeans means{.seconds = 10,
                          .specific_force_imu = 9.84 * axis,
                          .angular_rate_imu = 0.01 * random.normal_vector(3)};
    InertialStart start = static_start(Time(0), means, noise, {});
    const InertialStart before = start;
    widen_start_by_imu(calibration, {}, start);
    ASSERT_EQ(start.by_imu.cols(), 24);
    EXPECT_EQ(*start.covariance, *before.covariance);
    ImuCorrection errors;
    errors.add(1e-4 * random.normal_vector(24));
    const ImuSample mean =
        corrected(errors, ImuSample{.specific_force_imu = means.specific_force_imu,
                                    .angular_rate_imu = means.angular_rate_imu});
    means.specific_force_imu = mean.specific_force_imu;
    means.angular_rate_imu = mean.angular_rate_imu;
    const InertialStart other = static_start(Time(0), means, noise, {});
    Eigen::VectorXd moved(15);
    moved << so3::log(other.nav_T_imu.R * start.nav_T_imu.R.transpose()), other.nav_T_imu.p,
        other.v_nav, other.accelerometer_bias - start.accelerometer_bias,
        other.gyroscope_bias - start.gyroscope_bias;
    moved[2] = 0;  // the heading is free
    EXPECT_TRUE(test::agree(start.by_imu * errors.parameters(), moved, 1e-3)) << moved.transpose();
  }
}

// What the filter starts with: the errors of IMU and start are correlated, and turn with it.
TEST(StartByImu, IsInTheCovarianceOfTheFilter) {
  const InertialSlamSettings settings = with_imu(Calibrate::kTrue);
  const Calibration calibration = *stated_calibration(settings, {});
  InertialStart start{.time = Time(0), .nav_T_imu = {so3::exp({0.3, -0.2, 0.5}), {}}};
  start.covariance = Matrix15d::Identity() * 1e-6;
  const std::deque<ImuSample> samples{
      {.time = Time(1), .specific_force_imu = {1, 2, 9}, .angular_rate_imu = {0.3, 0, 0.1}},
      {.time = Time(100'000'000),
       .specific_force_imu = {-1, 2, 10},
       .angular_rate_imu = {-0.3, 0, 0.2}}};
  widen_start_by_imu(calibration, samples, start);
  EXPECT_GT((start.covariance->diagonal().tail<6>().array() - 1e-6).minCoeff(), 0);
  start = turned(start, 0.7);
  for (const bool nav : {false, true}) {
    InertialSlamSettings own = settings;
    own.nav_attitude = nav;
    if (nav) own.chart = "standard";
    const Ekf filter = initial_filter(own, start, {});
    const State& x = filter.state();
    NavScratch scratch;
    find_nav_derivative(x, scratch);
    const Eigen::MatrixXd P = filter.core_covariance();
    const Eigen::MatrixXd cross = (scratch.derivative * P).rightCols(24);
    EXPECT_TRUE(test::agree(cross, start.by_imu * calibration.covariance, 1e-12));
    const Eigen::MatrixXd given = nav_state(filter).covariance -
                                  start.by_imu * calibration.covariance * start.by_imu.transpose();
    EXPECT_TRUE(test::agree(given, *start.covariance, 1e-9, 0));
  }
}

// From a standstill, with a g-sensitivity that hides in the bias of the gyroscope until the IMU
// tilts, and again after a gap, with the calibration that was found.
TEST(ImuCalibration, OfASessionBeginsAtAStandstillAndOutlastsAGap) {
  InertialSlamSettings settings = with_imu(Calibrate::kTrue);
  settings.initial_g_sensitivity_sigma = 0.001;
  InertialScene scene = shaken(1);
  scene.settings.rest_duration = 3;
  scene.settings.start_duration = 1;
  scene.settings.sections = 2;
  constexpr std::uint64_t kRuns = 6;
  double parameters = 0, biases = 0;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const ImuCorrection errors = drawn_errors(settings, run);
    Recording recording = recorded_with(errors, simulate_inertial(scene, run));
    remove_samples(recording, 10, 10.7);  // the motion in between is unknown: a new part
    InertialSession session = session_for(recording, std::nullopt, settings);
    const Estimates estimates = play(session, recording);
    expect_sound(estimates);
    EXPECT_EQ(session.report().resets, 1);
    const Estimate* before = nullptr;
    const Estimate* anew = nullptr;
    for (const Estimate& e : estimates) {
      ASSERT_TRUE(e.calibration && e.calibration->imu);
      if (e.time < after(recording, 10)) before = &e;
      if (!anew && e.time > after(recording, 10.7)) anew = &e;
    }
    ASSERT_TRUE(before && anew);
    const auto sigmas = [](const Estimate& e) {
      return Eigen::VectorXd(e.calibration->covariance.diagonal().cwiseSqrt());
    };
    EXPECT_LT(sigmas(*before)[0], 0.9 * settings.initial_imu_scale_sigma);
    EXPECT_LT(sigmas(*anew).cwiseQuotient(sigmas(*before)).maxCoeff(), 1.05);
    const Estimate& last = estimates.back();
    parameters += nees_of(errors, *last.calibration);
    const auto truth = true_motion_at(recording, last.time);
    ASSERT_TRUE(truth);
    const Eigen::Vector3d error = truth->gyroscope_bias - last.additive.tail<3>();
    biases += normalised_square(error, last.covariance.bottomRightCorner<3, 3>());
  }
  EXPECT_LT(parameters / 24 / kRuns, 2.5) << "expected: 1; 500 with an independent start";
  EXPECT_LT(biases, chi2_quantile(0.9995, 3 * kRuns));
}

// Nothing shows the parameters during a standstill; they stay where they are, with their sigmas.
TEST(ImuCalibration, StaysSoundThroughALongStandstill) {
  const InertialSlamSettings settings = with_imu(Calibrate::kTrue);
  InertialScene scene = short_hallway();
  scene.settings.rest_duration = 60;
  scene.settings.start_duration = 1;
  scene.settings.sections = 1;
  const ImuCorrection errors = drawn_errors(settings, 3);
  const Recording recording = recorded_with(errors, simulate_inertial(scene, 3));
  InertialSession session = session_for(recording, std::nullopt, settings);
  const Estimates estimates = play(session, recording);
  expect_sound(estimates);
  int zero_velocity = 0;
  for (const Estimate& e : estimates) zero_velocity += e.zero_velocity ? 1 : 0;
  EXPECT_GT(zero_velocity, 1000);
  const Estimate& last = estimates.back();
  EXPECT_NE(last.health, Health::kLost);
  EXPECT_LT(nees_of(errors, *last.calibration), chi2_quantile(0.9995, 24));
  const auto truth = pose_at(recording.truth, last.time);
  EXPECT_LT((last.world_T_imu.p - truth->p).norm(), 0.5);
}

// The prediction between images is that of corrected samples.
TEST(ImuCalibration, IsInThePredictionBetweenImages) {
  const ImuCorrection errors = drawn_errors({}, 1);
  Estimate e;
  e.v_world = Eigen::Vector3d(1, 0, 0);
  e.additive = Eigen::VectorXd::Constant(6, 0.01);
  e.covariance = Eigen::MatrixXd::Identity(15, 15);
  StatePredictor right({}, {}), measured({}, {});
  for (int k = 0; k < 50; ++k) {
    const ImuSample sample{.time = from_seconds(0.01 * k),
                           .specific_force_imu = {std::sin(k), 1, 9.8},
                           .angular_rate_imu = {0.2, std::cos(k), 0.1}};
    right.add(sample);
    measured.add(as_measured(errors, sample));
  }
  right.correct(e);
  e.calibration = Calibration{.imu_T_camera = {}, .time_offset = {}, .imu = errors};
  measured.correct(e);
  const auto expected = right.at(from_seconds(0.455)), found = measured.at(from_seconds(0.455));
  ASSERT_TRUE(expected && found);
  EXPECT_LT((expected->state.world_T_imu.p - found->state.world_T_imu.p).norm(), 1e-12);
  EXPECT_LT((expected->state.world_T_imu.R - found->state.world_T_imu.R).norm(), 1e-12);
  EXPECT_LT((expected->angular_rate_imu - found->angular_rate_imu).norm(), 1e-12);
  EXPECT_LT((expected->covariance - found->covariance).norm(), 1e-9);
}

}  // namespace
}  // namespace chasles
