#include <algorithm>
#include <cmath>

#include <chasles/filter/relinearise.hpp>
#include <chasles/slam/landmark_updater.hpp>
#include <chasles/slam/step_testing.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::some_context;

std::optional<Eigen::Vector2d> predicted_pixel(const State& x, std::size_t landmark,
                                               const Camera& camera) {
  const Eigen::Vector3d p_imu = x.world_T_imu.inverse() * x.p_world(x.landmarks[landmark]);
  const auto seen = project(camera, camera.cam_T_imu * p_imu);
  return seen ? std::optional(seen->pixel) : std::nullopt;
}

// Every landmark by every camera that can, about a pixel from its prediction.
std::vector<PixelObservation> observations_of(const SlamContext& x, test::Random& random) {
  std::vector<PixelObservation> result;
  for (std::size_t c = 0; c < x.cameras.size(); ++c) {
    for (std::size_t i = 0; i < x.state().landmarks.size(); ++i) {
      const auto pixel = predicted_pixel(x.state(), i, x.cameras[c]);
      if (!pixel) continue;
      result.push_back({.landmark = x.state().landmarks[i].id,
                        .camera = static_cast<int>(c),
                        .pixel = *pixel + random.normal_vector(2)});
    }
  }
  return result;
}

// Residuals of these observations as a function of all errors.
VectorXd residuals(const SlamContext& x, const std::vector<PixelObservation>& pixels,
                   const VectorXd& e) {
  const State y = test::moved(kStandardChart, x.state(), e);
  VectorXd r(2 * std::ssize(pixels));
  Eigen::Index at = 0;
  for (const PixelObservation& o : pixels) {
    const auto i = static_cast<std::size_t>(
        std::ranges::find(y.landmarks, o.landmark, &Landmark::id) - y.landmarks.begin());
    r.segment<2>(at) = o.pixel - *predicted_pixel(y, i, x.camera(o.camera));
    at += 2;
  }
  return r;
}

struct UpdateKind {
  bool standstill = false;
  bool returned = false;
};

Estimate update(SlamContext& x, LandmarkUpdater& updater,
                const std::vector<PixelObservation>& pixels, UpdateKind kind = {}) {
  Estimate e;
  e.zero_velocity = kind.standstill;
  updater.update(x, test::pointers(pixels), kind.returned, StudyHooks(x.settings, {}), e);
  return e;
}

TEST(LandmarkUpdater, IsTheKalmanUpdateWithNumericDerivatives) {
  test::Random random(1);
  SlamContext x = some_context(random);
  const auto pixels = observations_of(x, random);
  ASSERT_GT(pixels.size(), 6u);
  const VectorXd zero = VectorXd::Zero(x.state().size());
  const auto r = [&](const VectorXd& e) { return residuals(x, pixels, e); };
  const MatrixXd H = -test::numeric_derivative(r, zero, test::kPixelStep);
  const MatrixXd R = 0.64 * MatrixXd::Identity(H.rows(), H.rows());
  const MatrixXd P = x.filter.covariance(), S = H * P * H.transpose() + R;
  const auto expected = test::updated(x.state(), P, H, R, r(zero));
  const double nis = r(zero).dot(S.inverse() * r(zero));

  LandmarkUpdater updater;
  const Estimate e = update(x, updater, pixels);
  test::expect_updated(x.filter, expected);
  EXPECT_NEAR(e.nis, nis, 1e-6 * nis);
  EXPECT_EQ(e.nis_dof, H.rows());
  EXPECT_EQ(e.used, std::ssize(pixels));
  EXPECT_EQ(e.rejected, 0);
  for (const PixelOutcome& one : updater.outcomes())
    EXPECT_EQ(one.outcome, chasles::Outcome::kUsed);
}

// The mean that minimises the squares of the prior and of the pixels: Gauss-Newton steps with
// numeric derivatives.
State least_squares(const SlamContext& x, const std::vector<PixelObservation>& pixels) {
  const MatrixXd information = MatrixXd(x.filter.covariance()).inverse();
  const auto error = [&](const VectorXd& e) { return residuals(x, pixels, e); };
  VectorXd e = VectorXd::Zero(information.rows());
  for (int step = 0; step < 20; ++step) {
    const MatrixXd H = -test::numeric_derivative(error, e, test::kPixelStep);
    e += (information + H.transpose() * H / 0.64)
             .ldlt()
             .solve(H.transpose() * error(e) / 0.64 - information * e);
  }
  return test::moved(kStandardChart, x.state(), e);
}

// The iterated Kalman filter (Bell & Cathey, IEEE T-AC 1993) with numeric derivatives by the errors
// at each linearisation point.
test::Updated iterated(const SlamContext& x, const std::vector<PixelObservation>& pixels) {
  const MatrixXd P = x.filter.covariance();
  const MatrixXd R = 0.64 * MatrixXd::Identity(2 * std::ssize(pixels), 2 * std::ssize(pixels));
  const VectorXd zero = VectorXd::Zero(P.rows());
  VectorXd e = zero;
  MatrixXd H;
  for (int step = 0; step < 20; ++step) {
    SlamContext there = x;
    there.filter = Ekf(kStandardChart, test::moved(kStandardChart, x.state(), e),
                       x.filter.core_covariance(), {.map = Ekf::Map::kFrozen});
    const auto error = [&](const VectorXd& d) { return residuals(there, pixels, d); };
    H = -test::numeric_derivative(error, zero, test::kPixelStep);
    e = P * H.transpose() * (H * P * H.transpose() + R).ldlt().solve(error(zero) + H * e);
  }
  return {test::moved(kStandardChart, x.state(), e),
          (P.inverse() + H.transpose() * H / 0.64).inverse()};
}

// The pixels of the landmarks from a pose that is some sigmas away, as after a long drift.
std::vector<PixelObservation> observations_after_drift(const SlamContext& x, test::Random& random) {
  const VectorXd e = 1.5 * test::normal_of(random, x.filter.covariance());
  const State truth = test::moved(kStandardChart, x.state(), e);
  std::vector<PixelObservation> result;
  for (std::size_t c = 0; c < x.cameras.size(); ++c) {
    for (std::size_t i = 0; i < truth.landmarks.size(); ++i) {
      const auto before = predicted_pixel(x.state(), i, x.cameras[c]);
      const auto pixel = predicted_pixel(truth, i, x.cameras[c]);
      if (!pixel || !before) continue;
      result.push_back({.landmark = truth.landmarks[i].id,
                        .camera = static_cast<int>(c),
                        .pixel = *pixel + 0.8 * random.normal_vector(2)});
    }
  }
  return result;
}

// After a closure the correction may be large: the update is that of the iterated filter, and leads
// nearer to the least squares than a single linearisation.
TEST(LandmarkUpdater, AfterAReturnItIsTheIteratedFilter) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    test::Random random(seed);
    SlamContext x = some_context(random);
    const auto pixels = observations_after_drift(x, random);
    ASSERT_GT(pixels.size(), 6u);
    const test::Updated expected = iterated(x, pixels);
    const State best = least_squares(x, pixels);
    SlamContext once = x;
    LandmarkUpdater updater, other;
    const Estimate e = update(x, updater, pixels, {.returned = true});
    EXPECT_EQ(e.used, std::ssize(pixels));
    update(once, other, pixels);
    const auto sigmas_between = [&](const State& y, const State& z) {
      const VectorXd off = correction_between(kStandardChart, y, z);
      return std::sqrt(off.dot(expected.P.ldlt().solve(off)));
    };
    EXPECT_LT(sigmas_between(x.state(), expected.x), 0.1) << seed;
    EXPECT_LT(sigmas_between(x.state(), best), 0.2 * sigmas_between(once.state(), best)) << seed;
    EXPECT_LT(test::covariance_difference(x.filter.covariance(), expected.P), 0.01) << seed;
  }
}

// First estimates keep their linearisation point.
TEST(LandmarkUpdater, FirstEstimatesAreNotLinearisedAgain) {
  test::Random random(1);
  SlamContext x = some_context(random);
  x.settings.first_estimates = Toggle::kTrue;
  const auto pixels = observations_after_drift(x, random);
  SlamContext once = x;
  LandmarkUpdater updater, other;
  update(x, updater, pixels, {.returned = true});
  update(once, other, pixels);
  EXPECT_EQ(test::distance(x.state(), once.state()), 0);
}

// In half a second a point slides by drift^2 / 2 px^2 in each coordinate of its camera: an anchored
// one across the rays of its anchor, a Cartesian one across its present ray, by the angle of a
// pixel. No other error changes.
TEST(LandmarkUpdater, DriftMovesThePointsAcrossTheirRays) {
  test::Random random(6);
  SlamContext x = some_context(random);
  x.settings.track_drift = 0.3;
  const MatrixXd before = x.filter.covariance();
  LandmarkUpdater{}.add_drift(x, from_seconds(0.5));
  MatrixXd added = x.filter.covariance() - before;
  for (const Landmark& landmark : x.state().landmarks) {
    const Camera& camera = x.camera(landmark.camera);
    const double u = 0.045 / (camera.fx * camera.fx), v = 0.045 / (camera.fy * camera.fy);
    Eigen::Matrix3d expected = Eigen::Vector3d(u, v, 0).asDiagonal();
    if (!landmark.anchor) {
      const Eigen::Vector3d ray =
          landmark.p_world - (x.state().world_T_imu * camera.cam_T_imu.inverse()).p;
      const Eigen::Vector3d e = ray.normalized();
      expected =
          (u + v) / 2 * ray.squaredNorm() * (Eigen::Matrix3d::Identity() - e * e.transpose());
    }
    auto noise = added.block<3, 3>(landmark.row, landmark.row);
    EXPECT_LT((noise - expected).cwiseAbs().maxCoeff(), 1e-9 * expected.norm() + 1e-16)
        << landmark.id;
    noise.setZero();
  }
  EXPECT_LT(added.cwiseAbs().maxCoeff(), 1e-15);

  x.settings.track_drift.reset();
  const MatrixXd unchanged = x.filter.covariance();
  LandmarkUpdater{}.add_drift(x, from_seconds(0.5));
  EXPECT_EQ(x.filter.covariance(), unchanged) << "without drift";
}

TEST(LandmarkUpdater, AGrossErrorIsRejectedAndChangesNothing) {
  test::Random random(2);
  SlamContext x = some_context(random);
  x.settings.gate = 0.999;
  auto pixels = observations_of(x, random);
  SlamContext without = x;
  LandmarkUpdater updater, other;
  auto fewer = pixels;
  fewer.erase(fewer.begin());
  pixels.front().pixel.x() += 1e4;
  const Estimate e = update(x, updater, pixels), f = update(without, other, fewer);
  EXPECT_EQ(e.used, f.used);
  EXPECT_EQ(e.rejected, f.rejected + 1);
  EXPECT_EQ(updater.outcomes().front().outcome, chasles::Outcome::kRejected);
  EXPECT_LT(test::distance(x.state(), without.state()), 1e-12);
}

TEST(LandmarkUpdater, NewPointsAreFreshAndAStandstillUpdatesNothing) {
  test::Random random(3);
  SlamContext x = some_context(random);
  auto pixels = observations_of(x, random);
  pixels.push_back({.landmark = 7, .camera = 1, .pixel = {100, 100}});
  const State before = x.state();
  LandmarkUpdater updater;
  const Estimate e = update(x, updater, pixels, {.standstill = true});
  EXPECT_EQ(e.used + e.rejected, 0);
  EXPECT_EQ(test::distance(x.state(), before), 0);
  ASSERT_EQ(updater.fresh().size(), 1u);
  EXPECT_EQ(updater.fresh().front()->landmark, 7);
  EXPECT_EQ(updater.outcomes().back().outcome, chasles::Outcome::kWaiting);
}

TEST(LandmarkUpdater, LandmarksLeaveThatAreRejectedOrOutOfView) {
  test::Random random(4);
  SlamContext x = some_context(random);
  x.settings.waiting_frames = 1;
  x.settings.max_rejections = 3;
  for (LandmarkRecord& record : x.records) record = {.seen = x.frame, .cameras = camera_bit(0)};
  x.records[1].rejected = 3;
  x.records[2].seen = x.records[3].seen = x.frame - 1;
  x.records[3].cameras = camera_bit(1);  // which observes nothing now
  LandmarkUpdater updater;
  EXPECT_EQ(updater.find_leaving(x, camera_bit(0)), std::vector<int>{1});
  EXPECT_EQ(x.records[2].missed, 1);
  EXPECT_EQ(updater.find_leaving(x, camera_bit(0)), (std::vector<int>{1, 2}));
  EXPECT_EQ(x.records[3].missed, 0);
  x.records[2].seen = x.frame;
  EXPECT_EQ(updater.find_leaving(x, camera_bit(0)), std::vector<int>{1}) << "in view again";
  EXPECT_EQ(x.records[2].missed, 0);
}

// A frame counts once as a rejection of its landmark by the gate; one that is used ends the row.
TEST(LandmarkUpdater, RejectionsInARowEndWithAUsedObservation) {
  test::Random random(7);
  SlamContext x = some_context(random);
  x.settings.gate = 0.999;
  x.settings.max_rejections = 2;
  const LandmarkId id = x.state().landmarks.front().id;
  const auto right = *predicted_pixel(x.state(), 0, x.camera(0));
  const auto observe = [&](const Eigen::Vector2d& off) {
    ++x.frame;
    LandmarkUpdater updater;
    const std::vector<PixelObservation> one{{.landmark = id, .camera = 0, .pixel = right + off}};
    update(x, updater, one);
    const auto& leaving = updater.find_leaving(x, 0);
    return std::ranges::count(leaving, 0) > 0;
  };
  EXPECT_FALSE(observe({500, 0}));
  EXPECT_FALSE(observe({0, 0}));
  EXPECT_EQ(x.records.front().rejected, 0);
  EXPECT_EQ(x.records.front().seen, x.frame);
  EXPECT_EQ(x.records.front().cameras, camera_bit(0));
  EXPECT_FALSE(observe({500, 0}));
  EXPECT_TRUE(observe({500, 0}));
  EXPECT_EQ(x.records.front().rejected, 2);
}

// The report of the frame: where the filter expected the pixel, and with which covariance.
TEST(LandmarkUpdater, AnOutcomeHasTheExpectedPixel) {
  test::Random random(8);
  SlamContext x = some_context(random);
  const auto pixel = *predicted_pixel(x.state(), 0, x.camera(0));
  const std::vector<PixelObservation> one{{.landmark = x.state().landmarks.front().id,
                                           .camera = 0,
                                           .pixel = pixel + Eigen::Vector2d(0.5, -1)}};
  const auto r = [&](const VectorXd& e) { return residuals(x, one, e); };
  const VectorXd zero = VectorXd::Zero(x.state().size());
  const MatrixXd H = test::numeric_derivative(r, zero, test::kPixelStep);
  const MatrixXd S = H * x.filter.covariance() * H.transpose() + 0.64 * Eigen::Matrix2d::Identity();
  LandmarkUpdater updater;
  update(x, updater, one);
  ASSERT_EQ(updater.outcomes().size(), 1u);
  const auto& expected = updater.outcomes().front().expected;
  ASSERT_TRUE(expected);
  EXPECT_LT((expected->pixel - pixel).norm(), 1e-9);
  EXPECT_TRUE(test::agree(expected->covariance, S, 1e-7));
}

// The last landmarks of the state are those that the frame has initialised. The outcomes are named
// by other observations, in the order of the update's.
TEST(LandmarkUpdater, InitialisedLandmarksAndOtherNamesAreNoted) {
  test::Random random(9);
  SlamContext x = some_context(random);
  const std::vector<PixelObservation> pixels{{.landmark = x.state().landmarks.front().id,
                                              .camera = 0,
                                              .pixel = *predicted_pixel(x.state(), 0, x.camera(0))},
                                             {.landmark = 7, .camera = 1, .pixel = {100, 100}},
                                             {.landmark = 8, .camera = 0, .pixel = {200, 100}},
                                             {.landmark = 7, .camera = 2, .pixel = {100, 90}}};
  LandmarkUpdater updater;
  update(x, updater, pixels);
  ASSERT_EQ(updater.fresh().size(), 3u);
  NewLandmark fresh;
  fresh.id = 7;
  fresh.noise = Eigen::Matrix3d::Identity();
  x.filter.add({&fresh, 1});
  x.records.push_back({.seen = x.frame});
  updater.note_initialised(x, 1);
  using enum chasles::Outcome;
  std::vector<chasles::Outcome> outcomes;
  for (const PixelOutcome& one : updater.outcomes()) outcomes.push_back(one.outcome);
  EXPECT_EQ(outcomes, (std::vector{kUsed, kInitialised, kWaiting, kInitialised}));
  EXPECT_EQ(x.records.back().cameras, camera_bit(1) | camera_bit(2));

  updater.name_outcomes(test::pointers(pixels), [](PixelObservation o) {
    o.landmark += 1000;
    return o;
  });
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    EXPECT_EQ(updater.outcomes()[i].observation.landmark, pixels[i].landmark + 1000);
    EXPECT_EQ(updater.outcomes()[i].observation.pixel, pixels[i].pixel);
  }
}

TEST(LandmarkUpdater, AKnownDepthMakesALandmarkCartesian) {
  test::Random random(5);
  SlamContext x = some_context(random);
  x.settings.settled_depth_sigma = 0;
  LandmarkUpdater updater;
  const auto anchored = [&] {
    return std::ranges::count_if(x.state().landmarks,
                                 [](const Landmark& l) { return l.anchor.has_value(); });
  };
  updater.make_cartesian(x);
  EXPECT_EQ(anchored(), 3);
  x.settings.settled_depth_sigma = 10;
  updater.make_cartesian(x);
  EXPECT_EQ(anchored(), 0);
}

}  // namespace
}  // namespace chasles
