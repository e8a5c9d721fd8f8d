#include <cmath>
#include <string>

#include <Eigen/Cholesky>

#include <chasles/base/error.hpp>
#include <chasles/filter/inertial_testing.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr Ekf::Options kKept{.map = Ekf::Map::kFrozen, .keep_scale = true};
constexpr Ekf::Options kPlain{.map = Ekf::Map::kFrozen};

// At the IMU: a lever arm would be a known length.
Camera camera_at_imu() {
  Camera camera = test::inertial_cameras()[0];
  camera.cam_T_imu.p.setZero();
  return camera;
}

// One clone with four landmarks, and four Cartesian ones, all correlated, observed after a motion
// of two metres. `depth_sigma`: relative standard deviation of the depths.
Ekf filter_with_landmarks(const ErrorChart& chart, test::Random& random, Ekf::Options options,
                          double depth_sigma) {
  State x = test::random_state(random, {.velocity = true, .additive = 6});
  Ekf filter(chart, x, test::random_covariance(random, x.core_size(), 0.02), options);
  filter.clone_pose(0, Time{});
  for (int i = 0; i < 4; ++i) {
    test::add_anchored(filter, random, i, camera_at_imu());
    NewLandmark fresh;
    fresh.id = 10 + i;
    const Vector3d ahead = test::point_ahead(random, random.uniform(6, 12));
    fresh.p_world = filter.state().world_T_imu * ahead;
    fresh.d_pose << -hat(fresh.p_world - filter.state().world_T_imu.p), Eigen::Matrix3d::Identity();
    fresh.noise = test::random_covariance(random, 3, depth_sigma * ahead.norm());
    filter.add({&fresh, 1});
  }
  const int n = x.core_size();
  Prediction step{.world_T_imu = filter.state().world_T_imu,
                  .v_world = filter.state().v_world,
                  .additive = filter.state().additive,
                  .F = MatrixXd::Identity(n, n),
                  .Q = test::random_covariance(random, n, 0.02)};
  step.world_T_imu.p += step.world_T_imu.R * Vector3d(0.5, 2, 0.3);
  filter.propagate(step);
  return filter;
}

std::vector<Measurement> observations(const State& x, test::Random& random) {
  std::vector<Measurement> result;
  for (int i = 0; i < static_cast<int>(x.landmarks.size()); ++i) {
    auto z = measure_pixel(camera_at_imu(), 1, x, i, Eigen::Vector2d::Zero(),
                           Linearisation::kCurrent, 0);
    if (!z) continue;
    z->residual = 10 * random.normal_vector(2);
    result.push_back(*z);
  }
  return result;
}

// d/ds of all distances scaled by e^s, by hand. No pixel depends on the velocity.
VectorXd scale_direction(const State& x) {
  VectorXd s = VectorXd::Zero(x.size());
  s.segment<3>(3) = x.world_T_imu.p;
  for (const Clone& clone : x.clones) s.segment<3>(clone.row + 3) = clone.world_T_imu.p;
  for (const Landmark& l : x.landmarks) {
    const double w = l.inverse_depth.z();
    s.segment<3>(l.row) = l.anchor ? Vector3d(0, 0, -w) : l.p_world;
  }
  return s;
}

// Information along the direction, all else fixed: s^T P^-1 s.
double information(const Ekf& filter) {
  const VectorXd s = scale_direction(filter.state());
  return s.dot(MatrixXd(filter.covariance()).llt().solve(s));
}

// The information on the scale after three updates, divided by that before.
double gain(const char* chart, Ekf::Options options, int seed) {
  test::Random random(seed);
  Ekf filter = filter_with_landmarks(error_chart(chart), random, options, 0.02);
  const double before = information(filter);
  for (int pass = 0; pass < 3; ++pass) {
    const auto z = observations(filter.state(), random);
    EXPECT_EQ(z.size(), 8u);
    EXPECT_FALSE(filter.update(z).failed);
  }
  return information(filter) / before;
}

struct Both {
  Ekf kept, plain;
};

// The same update of a filter with keep_scale and of one without.
Both both_updated(const ErrorChart& chart, int seed) {
  test::Random random(seed), again(seed);
  Both both{.kept = filter_with_landmarks(chart, random, kKept, 0.02),
            .plain = filter_with_landmarks(chart, again, kPlain, 0.02)};
  const auto z = observations(both.kept.state(), random);
  both.kept.update(z);
  both.plain.update(z);
  return both;
}

TEST(EkfScale, PixelsShowNothingOfIt) {
  for (const char* chart : {"standard", "right-se3", "right-sen3"}) {
    for (int seed = 0; seed < 5; ++seed) {
      EXPECT_NEAR(gain(chart, kKept, seed), 1, 1e-6) << chart << seed;
      EXPECT_GT(gain(chart, kPlain, seed), 1.001) << chart << seed;
    }
  }
}

// The velocity changes in an update for reasons other than scale, such as the noise of the samples.
// That is no change of scale, so its covariance is that of the plain update.
TEST(EkfScale, VelocityIsNoPartOfIt) {
  const Both both = both_updated(kRightSen3Chart, 3);
  const MatrixXd a = both.kept.covariance(), b = both.plain.covariance();
  EXPECT_LT((a.block<3, 3>(6, 6) - b.block<3, 3>(6, 6)).norm(), 1e-12 * b.norm());
  EXPECT_GT((a.block<3, 3>(3, 3) - b.block<3, 3>(3, 3)).norm(), 1e-6 * b.norm());
}

// Landmarks whose distances have independent errors of 3 % and 6 %, seen from a certain pose:
// weighted by their variances, the error that they have in common has
// 1 / (1 / 0.03^2 + 1 / 0.06^2).
TEST(EkfScale, SigmaIsThatOfTheMeanDistance) {
  test::Random random(1);
  const State x = test::random_state(random, {.velocity = true, .additive = 6});
  const MatrixXd certain = 1e-18 * MatrixXd::Identity(x.core_size(), x.core_size());
  Ekf filter(kStandardChart, x, certain, kKept), plain(kStandardChart, x, certain, kPlain);
  EXPECT_FALSE(filter.scale_sigma());
  for (const double relative : {0.03, 0.06}) {
    NewLandmark fresh;
    fresh.id = static_cast<int>(100 * relative);
    const Vector3d away = test::point_ahead(random, 7);
    fresh.p_world = x.world_T_imu * away;
    fresh.noise = std::pow(relative * away.norm(), 2) * Eigen::Matrix3d::Identity();
    filter.add({&fresh, 1});
    plain.add({&fresh, 1});
  }
  ASSERT_TRUE(filter.scale_sigma());
  EXPECT_NEAR(*filter.scale_sigma(), 1 / std::hypot(1 / 0.03, 1 / 0.06), 1e-9);
  EXPECT_FALSE(plain.scale_sigma());
}

TEST(EkfScale, MeansAreThoseOfThePlainUpdate) {
  const Both both = both_updated(kStandardChart, 1);
  // Fused multiplication and addition may round differently in the two.
  EXPECT_LT(local(kStandardChart, both.kept.state(), both.plain.state()).norm(), 1e-15);
  const MatrixXd P = both.kept.covariance();
  EXPECT_EQ(P, P.transpose());
  EXPECT_EQ(P.llt().info(), Eigen::Success);
}

// The error of an assumed depth is not an error of scale.
TEST(EkfScale, GuessedDepthsSayNothing) {
  test::Random random(1), again(1);
  const auto guessed = [](test::Random& r, Ekf::Options options) {
    State x = test::random_state(r, {.velocity = true, .additive = 6});
    Ekf filter(kStandardChart, x, test::random_covariance(r, x.core_size(), 0.02), options);
    filter.clone_pose(0, Time{});
    NewLandmark fresh;
    fresh.id = 1;
    fresh.anchor = 0;
    fresh.cam_T_imu = camera_at_imu().cam_T_imu;
    fresh.inverse_depth << 0.1, 0.1, 0.1;
    fresh.noise = Vector3d(1e-6, 1e-6, 0.25).asDiagonal();
    filter.add({&fresh, 1});
    test::walk_on(filter, r);
    return filter;
  };
  Ekf kept = guessed(random, kKept), plain = guessed(again, kPlain);
  const auto z = observations(kept.state(), random);
  ASSERT_EQ(z.size(), 1u);
  kept.update(z);
  plain.update(z);
  EXPECT_EQ(MatrixXd(kept.covariance()), MatrixXd(plain.covariance()));
}

TEST(EkfScale, RejectsWhatItCannotDo) {
  test::Random random(1);
  const State x = test::random_state(random, {.velocity = true, .additive = 6});
  const State drive = test::random_state(random, {.velocity = false, .additive = 6});
  const auto message = [&](const ErrorChart& chart, const State& state, Ekf::Options options) {
    const int n = state.core_size();
    try {
      const Ekf filter(chart, state, MatrixXd::Identity(n, n), options);
    } catch (const UsageError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_EQ(message(kRightSen3Chart, x, kKept), "");
  EXPECT_NE(message(kLeftSe3Chart, x, kKept).find("left-se3"), std::string::npos);
  EXPECT_NE(message(kStandardChart, drive, kKept).find("inertial"), std::string::npos);
  EXPECT_NE(message(kStandardChart, x, {.keep_scale = true}).find("Map::kHistory"),
            std::string::npos);
}

}  // namespace
}  // namespace chasles
