#include <cmath>

#include <Eigen/Cholesky>

#include <chasles/filter/drive_motion_testing.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/filter/testing.hpp>
#include <chasles/velocity/stereo_measurement.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Consistency of the filter. The truth is drawn from the filter's initial distribution and
// propagated by the filter's model, so that the test covers only the filter.

constexpr int kRuns = 120;
constexpr int kFrames = 10;
constexpr int kInScene = 8;
constexpr BodyVelocityModel kOwnAxes{.velocity_state = true, .gyro_bias = true, .scale = false};
constexpr BodyVelocityModel kLevelAxes{
    .velocity_state = true, .gyro_bias = true, .scale = false, .level = true};
constexpr StereoNoise kNoise{.u = 0.5, .v = 0.5, .disparity = 0.5};

BodyVelocityNoise motion_noise() {
  BodyVelocityNoise noise{.sample_sigma = {},
                          .walk = {},
                          .gyro_bias_walk = 1e-3,
                          .scale_walk = 0,
                          .tilt_walk = 1e-3,
                          .heading_walk = 1e-3};
  noise.sample_sigma << 0.01, 0.01, 0.01, 0.1, 0.1, 0.1;
  noise.walk << 0.1, 0.1, 0.1, 0.5, 0.5, 0.5;
  return noise;
}

using ConsistencyTest = test::OverCharts;
INSTANTIATE_TEST_SUITE_P(Charts, ConsistencyTest, ::testing::ValuesIn(test::all_charts()),
                         test::chart_test_name);

struct Squares {
  double nees = 0, nees_dof = 0, nis = 0, nis_dof = 0;
};

State advanced(const BodyVelocityModel& model, const State& x, test::Random& random) {
  const Prediction step = predict(model, x, {}, test::kDriveStep, motion_noise());
  State next = x;
  next.world_T_imu = step.world_T_imu;
  next.additive = step.additive;
  // Q correlates pose and velocity so strongly that it needs a square root that may be singular.
  const Eigen::LDLT<MatrixXd> ldlt(step.Q);
  VectorXd w =
      ldlt.vectorD().cwiseMax(0).cwiseSqrt().cwiseProduct(random.normal_vector(step.Q.rows()));
  w = ldlt.transpositionsP().transpose() * VectorXd(ldlt.matrixL() * w);
  VectorXd xi = VectorXd::Zero(test::error_rows(x));
  xi.head(w.size()) = w;
  kStandardChart.retract(next, xi);
  return next;
}

BodyVelocity sampled(const BodyVelocityModel& model, const State& truth, test::Random& random) {
  const VectorXd noise = motion_noise().sample_sigma.cwiseProduct(random.normal_vector(6));
  Eigen::Matrix3d sample_R_imu = Eigen::Matrix3d::Identity();
  if (model.level) {
    const Eigen::Vector3d t(truth.additive[model.tilt_index()],
                            truth.additive[model.tilt_index() + 1], 0);
    const Eigen::Matrix3d nav_R_imu = so3::exp(t) * truth.world_T_imu.R;
    const double turn =
        truth.additive[model.heading_index()] - std::atan2(nav_R_imu(1, 0), nav_R_imu(0, 0));
    sample_R_imu = so3::exp(turn * Eigen::Vector3d::UnitZ()) * nav_R_imu;
  }
  const Eigen::Vector3d bias = truth.additive.segment<3>(model.bias_index());
  return {.time = {},
          .linear_imu = sample_R_imu * truth.additive.segment<3>(3) + noise.tail<3>(),
          .angular_imu = sample_R_imu * truth.additive.head<3>() + bias + noise.head<3>()};
}

StereoObservation seen(const State& truth, int landmark, test::Random& random) {
  const StereoRig rig = test::drive_rig();
  const Eigen::Vector3d p_world = truth.landmarks[static_cast<std::size_t>(landmark)].p_world;
  const auto projection = project(rig, rig.cam0_T_imu * (truth.world_T_imu.inverse() * p_world));
  const Eigen::Vector3d n = kNoise.u * random.normal_vector(3);
  return {.landmark = landmark,
          .pixels = projection.value().pixels +
                    Eigen::Vector4d(n[0] + n[2] / 2, n[1], n[0] - n[2] / 2, n[1])};
}

// The filter's initial mean: forward motion at 1 m/s.
State first_estimate(const BodyVelocityModel& model) {
  State x;
  x.additive.setZero(model.size());
  x.additive.head<6>() << 0, 0, 0.1, 1, 0, 0;
  return x;
}

VectorXd first_sigma(const BodyVelocityModel& model) {
  VectorXd sigma = VectorXd::Constant(6 + model.size(), 0.05);  // tilt and heading, at the end
  sigma.head<15>() << 0.01, 0.01, 0.01, 0.05, 0.05, 0.05, 0.1, 0.1, 0.1, 0.3, 0.3, 0.3, 0.02, 0.02,
      0.02;
  return sigma;
}

// One run; `uses` is the number of times each observation is used in the update.
void drive(const BodyVelocityModel& model, const ErrorChart& chart, test::Random& random, int uses,
           Squares& squares) {
  const int core = 6 + model.size();
  Ekf ekf(chart, first_estimate(model), first_sigma(model).cwiseAbs2().asDiagonal(), {});
  State truth = first_estimate(model);
  kStandardChart.retract(truth, first_sigma(model).cwiseProduct(random.normal_vector(core)));
  std::vector<NewLandmark> fresh;
  for (int i = 0; i < kInScene; ++i) {
    const double z = random.uniform(-1, 2), y = random.uniform(-3, 3), x = random.uniform(5, 8);
    const Eigen::Vector3d p(x, y, z);
    truth.landmarks.push_back({.id = i, .p_world = p, .row = core + 3 * i, .observations = 0});
    fresh.push_back(
        *initialise_landmark(test::drive_rig(), kNoise, ekf.state(), seen(truth, i, random)));
  }
  ekf.add(fresh);
  const auto count = [&](const std::vector<Measurement>& measurements) {
    const UpdateReport report = ekf.update(measurements);
    squares.nis += report.nis;
    squares.nis_dof += report.dof;
  };
  for (int k = 0; k < kFrames; ++k) {
    truth = advanced(model, truth, random);
    ekf.propagate(predict(model, ekf.state(), {}, test::kDriveStep, motion_noise()));
    count({measure_velocity(model, ekf.state(), sampled(model, truth, random), motion_noise())});
    std::vector<Measurement> measurements;
    for (int i = 0; i < kInScene; ++i) {
      const auto z = measure_stereo(test::drive_rig(), StereoRows::kMeanDisparity, kNoise,
                                    ekf.state(), i, seen(truth, i, random));
      for (int use = 0; use < uses; ++use) measurements.push_back(z.value());
    }
    count(measurements);
  }
  VectorXd error = chart.local(ekf.state(), truth);
  pull(chart, ekf.state(), error);
  squares.nees += error.dot(ekf.covariance().llt().solve(error));
  squares.nees_dof += static_cast<double>(error.size());
}

Squares many_drives(const BodyVelocityModel& model, const ErrorChart& chart, int uses) {
  test::Random random(2024);
  Squares squares;
  for (int i = 0; i < kRuns; ++i) drive(model, chart, random, uses, squares);
  return squares;
}

TEST_P(ConsistencyTest, ErrorsAndInnovationsAreAsLargeAsTheFilterSays) {
  for (const BodyVelocityModel& model : {kOwnAxes, kLevelAxes}) {
    const Squares squares = many_drives(model, chart(), 1);
    EXPECT_TRUE(test::is_chi2(squares.nees, squares.nees_dof)) << model.level;
    EXPECT_TRUE(test::is_chi2(squares.nis, squares.nis_dof)) << model.level;
  }
}

TEST_P(ConsistencyTest, ObservationUsedTwiceMakesTheFilterTooSure) {
  const Squares squares = many_drives(kOwnAxes, chart(), 2);
  EXPECT_FALSE(test::is_chi2(squares.nees, squares.nees_dof));
  EXPECT_GT(squares.nees, squares.nees_dof);
}

}  // namespace
}  // namespace chasles
