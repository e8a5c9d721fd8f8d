#include <iterator>

#include <chasles/slam/step_testing.hpp>
#include <chasles/slam/track_updater.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::some_context;

constexpr LandmarkId kTrack = 7;

// A point that cameras 0 and 1 observe from all clones of the context, with noise.
struct SeenFromClones {
  Eigen::Vector3d p_world;
  std::vector<std::pair<int, PixelObservation>> views;  ///< with the clone
};

SeenFromClones seen_from_clones(const SlamContext& x, test::Random& random) {
  SeenFromClones seen{x.state().world_T_imu * test::point_ahead(random, 8), {}};
  for (const Clone& clone : x.state().clones) {
    for (const int camera : {0, 1}) {
      const Eigen::Vector2d pixel =
          test::pixel_of(x.camera(camera), clone.world_T_imu, seen.p_world);
      seen.views.push_back(
          {clone.id,
           {.landmark = kTrack, .camera = camera, .pixel = pixel + 0.5 * random.normal_vector(2)}});
    }
  }
  return seen;
}

void add(SlamContext& x, TrackUpdater& updater, const SeenFromClones& seen) {
  const int now = x.frame;
  for (const auto& [clone, o] : seen.views) {
    x.frame = clone;
    updater.add(x, o, true);
  }
  x.frame = now;
}

// The least-squares point of the views.
Eigen::Vector3d triangulated(const SlamContext& x, const SeenFromClones& seen) {
  Eigen::Vector3d p = seen.p_world;
  for (int i = 0; i < 10; ++i) {
    Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (const auto& [clone, o] : seen.views) {
      const SE3 cam_T_world =
          x.camera(o.camera).cam_T_imu * x.state().clone(clone).world_T_imu.inverse();
      const auto pixel = project(x.camera(o.camera), cam_T_world * p);
      const MatrixXd J = pixel->d_point * cam_T_world.R;
      N += J.transpose() * J;
      b += J.transpose() * (o.pixel - pixel->pixel);
    }
    p += N.inverse() * b;
  }
  return p;
}

// A track out of view updates the clones by its residuals without the point: least squares of all
// views, whose derivatives are numeric, with a flat prior of the point.
TEST(TrackUpdater, ALostTrackIsLeastSquaresOverItsClones) {
  test::Random random(1);
  SlamContext x = some_context(random);
  const SeenFromClones seen = seen_from_clones(x, random);
  const Eigen::Vector3d point = triangulated(x, seen);
  const State before = x.state();
  const auto n = static_cast<Eigen::Index>(before.size());
  const auto residuals = [&](const VectorXd& e) -> VectorXd {
    const State y = test::moved(kStandardChart, before, e.head(n));
    VectorXd r(2 * std::ssize(seen.views));
    Eigen::Index at = 0;
    for (const auto& [clone, o] : seen.views) {
      r.segment<2>(at) = o.pixel - test::pixel_of(x.camera(o.camera), y.clone(clone).world_T_imu,
                                                  point + e.tail<3>());
      at += 2;
    }
    return r;
  };
  const VectorXd zero = VectorXd::Zero(n + 3);
  const MatrixXd H = -test::numeric_derivative(residuals, zero, test::kPixelStep);
  MatrixXd information = H.transpose() * H / 0.64;
  information.topLeftCorner(n, n) += MatrixXd(x.filter.covariance()).inverse();
  const MatrixXd P = information.inverse();
  const VectorXd delta = P * H.transpose() * residuals(zero) / 0.64;

  TrackUpdater updater(x.settings);
  add(x, updater, seen);
  EXPECT_EQ(updater.update(x, camera_bit(0), CloneWindow{}), 0);
  EXPECT_EQ(updater.tracks().size(), 0u);
  EXPECT_GT(test::distance(x.state(), before), 1e-4);
  EXPECT_LT(test::distance(x.state(), test::moved(kStandardChart, before, delta.head(n))), 1e-6);
  EXPECT_LT(test::covariance_difference(x.filter.covariance(), P.topLeftCorner(n, n)), 1e-6);
}

TEST(TrackUpdater, AGrossErrorDoesNotPassTheGate) {
  test::Random random(2);
  SlamContext x = some_context(random);
  x.settings.gate = 0.999;
  x.settings.max_landmarks = x.settings.min_landmarks = 0;
  SeenFromClones seen = seen_from_clones(x, random);
  seen.views[2].second.pixel.y() += 40;  // across the base of the two cameras
  const State before = x.state();
  TrackUpdater updater(x.settings);
  add(x, updater, seen);
  updater.update(x, camera_bit(0), CloneWindow{});
  EXPECT_EQ(test::distance(x.state(), before), 0);
  const TrackUse use = updater.use(x);
  EXPECT_EQ(use.used, 0);
  EXPECT_EQ(use.rejected, 1);
}

// A camera that observes nothing does not end the track.
TEST(TrackUpdater, ATrackWaitsWhileItsCamerasAreBlind) {
  test::Random random(3);
  SlamContext x = some_context(random);
  TrackUpdater updater(x.settings);
  add(x, updater, seen_from_clones(x, random));
  updater.update(x, camera_bit(2), CloneWindow{});
  EXPECT_EQ(updater.tracks().size(), 1u);
}

// Camera 1 also matched it, but camera 0 found it, and has no image now.
TEST(TrackUpdater, ATrackWaitsForTheCameraThatFoundIt) {
  test::Random random(5);
  for (const bool known : {true, false}) {
    SlamContext x = some_context(random);
    x.settings.max_landmarks = 0;
    TrackUpdater updater(x.settings);
    SeenFromClones seen = seen_from_clones(x, random);
    for (auto& [clone, o] : seen.views) {
      if (known) o.match = o.camera == 1;
    }
    add(x, updater, seen);
    updater.update(x, camera_bit(1), CloneWindow());
    EXPECT_EQ(updater.tracks().size(), known ? 1u : 0u);
  }
}

// When the window is full, the tracks with a view in its oldest clone have their last chance: they
// update the filter as if they were lost, and wait with new views. Others wait.
TEST(TrackUpdater, WhereTheWindowIsFullTracksOfItsOldestCloneUpdate) {
  test::Random random(6);
  SlamContext x = some_context(random);
  x.settings.max_landmarks = 0;
  x.settings.frames_per_clone = 1;
  x.settings.clones = 2;
  CloneWindow clones;
  const auto augment = [&] {
    ++x.frame;
    clones.augment(x, {.time = from_seconds(x.frame), .pixels = {{.landmark = kTrack}}}, false);
  };
  const SeenFromClones seen = seen_from_clones(x, random);
  TrackUpdater updater(x.settings);
  add(x, updater, seen);
  const auto see = [&](LandmarkId id) {
    updater.add(x,
                {.landmark = id,
                 .camera = 0,
                 .pixel = test::pixel_of(x.camera(0), x.state().world_T_imu, seen.p_world)},
                true);
  };
  augment();
  const int oldest = x.frame;
  see(kTrack);
  const State before = x.state();
  updater.update(x, camera_bit(0), clones);
  EXPECT_EQ(test::distance(x.state(), before), 0) << "there is room for a clone";

  augment();
  see(kTrack);
  see(kTrack + 1);  // begins in this frame
  ASSERT_TRUE(clones.full(x.settings));
  ASSERT_EQ(clones.oldest(), oldest);
  SlamContext lost = x;
  TrackUpdater of_lost = updater;
  ++lost.frame;
  of_lost.update(lost, camera_bit(0), CloneWindow{});
  ASSERT_GT(test::distance(lost.state(), before), 1e-4);

  EXPECT_EQ(updater.update(x, camera_bit(0), clones), 0);
  EXPECT_LT(test::distance(x.state(), lost.state()), 1e-12);
  EXPECT_LT(test::covariance_difference(x.filter.covariance(), lost.filter.covariance()), 1e-12);
  ASSERT_EQ(updater.tracks().size(), 2u);
  EXPECT_TRUE(updater.tracks().begin()->views.empty()) << "every observation is used once";
  EXPECT_EQ(std::next(updater.tracks().begin())->views.size(), 1u) << "not in the oldest clone";
  EXPECT_EQ(of_lost.tracks().size(), 0u);
}

TEST(TrackUpdater, AKnownDepthMakesALandmark) {
  test::Random random(4);
  SlamContext x = some_context(random);
  x.settings.min_parallax = 0;
  x.settings.max_relative_depth_sigma = x.settings.max_total_depth_sigma = 1e3;
  SeenFromClones seen = seen_from_clones(x, random);
  CloneWindow clones;
  const FeatureFrame frame{.time = x.now, .pixels = {seen.views.front().second}};
  clones.augment(x, frame, false);
  ASSERT_TRUE(clones.augmented());
  TrackUpdater updater(x.settings);
  add(x, updater, seen);
  updater.add(x,
              {.landmark = kTrack,
               .camera = 0,
               .pixel = test::pixel_of(x.camera(0), x.state().world_T_imu, seen.p_world)},
              true);
  const std::size_t before = x.state().landmarks.size();
  EXPECT_EQ(updater.update(x, camera_bit(0), clones), 1);
  ASSERT_EQ(x.state().landmarks.size(), before + 1);
  EXPECT_EQ(x.records.size(), before + 1);
  const Landmark& landmark = x.state().landmarks.back();
  EXPECT_EQ(landmark.id, kTrack);
  EXPECT_EQ(landmark.observations, 7);
  EXPECT_EQ(updater.tracks().size(), 0u);
}

TEST(TrackUpdater, MissingLandmarksAreInitialisedAtTheAssumedDepth) {
  test::Random random(5);
  SlamContext x = some_context(random);
  x.settings.min_landmarks = static_cast<int>(x.state().landmarks.size()) + 1;
  CloneWindow clones;
  clones.augment(x, {.time = x.now, .pixels = {{.landmark = 1}}}, false);
  TrackUpdater updater(x.settings);
  for (const LandmarkId id : {kTrack, kTrack + 1}) {
    updater.add(x, {.landmark = id, .camera = 0, .pixel = {300, 200}}, clones.augmented());
  }
  EXPECT_EQ(updater.initialise_missing(x, UndelayedInitialiser(DepthRule{})), 1);
  EXPECT_EQ(x.state().landmarks.back().id, kTrack);
  EXPECT_NEAR(x.state().landmarks.back().inverse_depth.z(), x.settings.inverse_depth, 1e-12);
  EXPECT_EQ(updater.tracks().size(), 1u);
}

}  // namespace
}  // namespace chasles
