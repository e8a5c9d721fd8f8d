#include <gtest/gtest.h>

#include <chasles/filter/testing.hpp>
#include <chasles/smooth/batch/batch.hpp>
#include <chasles/smooth/batch/batch_oracle_testing.hpp>

namespace chasles {
namespace {

using test::motion_error;
using test::small_scene;
using test::SmallScene;

BatchSettings exact(LandmarkForm landmarks = LandmarkForm::kCartesian) {
  BatchSettings settings;
  settings.landmarks = landmarks;
  settings.inverse_depth_sigma = 1e9;
  settings.min_parallax = 0;
  settings.loss = BatchLoss::kNone;
  settings.tolerance = 1e-15;
  settings.max_iterations = 200;
  settings.covariance_factor = 1;
  return settings;
}

class Batch : public test::OverCharts {
 protected:
  std::string name() const { return std::string(chart().name); }
};

TEST_P(Batch, IsTheMinimumThatADenseGaussNewtonFinds) {
  for (const bool beside : {false, true}) {
    SmallScene scene = small_scene({.frames = 6, .cameras = 2, .landmarks = 14, .beside = beside});
    scene.input.match_sigma = 0.3;
    test::BatchOracle oracle(scene);
    oracle.solve(8);
    const Eigen::MatrixXd P = oracle.covariance();
    for (const LandmarkForm landmarks : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
      const InertialBatchResult result = smooth(scene.input, name(), exact(landmarks));
      ASSERT_EQ(result.estimates.size(), oracle.states().size());
      EXPECT_NEAR(result.report.final_cost / oracle.cost(), 1, 1e-6);
      for (std::size_t k = 0; k < result.estimates.size(); ++k) {
        const Estimate& m = result.estimates[k];
        EXPECT_LT(motion_error(oracle.states()[k], m).cwiseAbs().maxCoeff(), 1e-6)
            << "keyframe " << k;
        const auto at = 15 * static_cast<Eigen::Index>(k);
        EXPECT_LT(test::covariance_difference(m.covariance, P.block(at, at, 15, 15)), 1e-4);
      }
      Eigen::Index at = 15 * std::ssize(result.estimates);
      for (const auto& [id, p] : oracle.points()) {
        const auto found = std::ranges::find(result.landmarks, id, &MapLandmark::id);
        ASSERT_NE(found, result.landmarks.end());
        EXPECT_LT((found->p_world - p).norm(), 1e-5);
        EXPECT_LT(test::covariance_difference(found->covariance, P.block(at, at, 3, 3)), 1e-4);
        at += 3;
      }
    }
  }
}

TEST_P(Batch, HasConvergedWhereNothingIsLeftToGainThoughItsStepsAreUsedUp) {
  const SmallScene scene = small_scene({.frames = 6, .cameras = 2, .landmarks = 14});
  BatchSettings settings = exact();
  const BatchReport whole = smooth(scene.input, name(), settings).report;
  settings.max_iterations = whole.iterations - 1;
  const BatchReport short_of_its_end = smooth(scene.input, name(), settings).report;
  EXPECT_EQ(short_of_its_end.iterations, settings.max_iterations);
  EXPECT_LT(short_of_its_end.decrease_left, 1e-7);
  EXPECT_TRUE(short_of_its_end.converged);
  settings.max_iterations = 1;
  const BatchReport far = smooth(scene.input, name(), settings).report;
  EXPECT_GT(far.decrease_left, 1e-7);
  EXPECT_FALSE(far.converged);
}

TEST_P(Batch, WithoutNoiseFindsTheTruthFromABadBeginning) {
  SmallScene scene = small_scene({.frames = 12, .noise = 0});
  // The prior is unbiased; the search starts elsewhere.
  test::Random random(7);
  for (const TimedMotion& m : scene.truth) {
    scene.input.initial.push_back(m);
    InertialState& s = scene.input.initial.back().state;
    s.world_T_imu.R = so3::exp(0.05 * random.normal_vector(3)) * s.world_T_imu.R;
    s.world_T_imu.p += 0.1 * random.normal_vector(3);
    s.v_world += 0.3 * random.normal_vector(3);
    s.gyroscope_bias += 0.02 * random.normal_vector(3);
  }
  for (const LandmarkForm landmarks : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    const InertialBatchResult result = smooth(scene.input, name(), exact(landmarks));
    EXPECT_TRUE(result.report.converged) << result.report.end;
    for (std::size_t k = 0; k < result.estimates.size(); ++k) {
      EXPECT_LT(motion_error(scene.truth[k].state, result.estimates[k]).norm(), 1e-5);
    }
    for (const MapLandmark& l : result.landmarks) {
      EXPECT_LT((l.p_world - scene.landmarks.at(l.id)).norm(), 1e-4);
    }
  }
}

TEST_P(Batch, KnowsHowWrongItIs) {
  double poses = 0, states = 0;
  int runs = 0;
  for (; runs < 30; ++runs) {
    const SmallScene scene =
        small_scene({.frames = 8, .seed = 100 + static_cast<std::uint64_t>(runs)});
    BatchSettings settings;
    settings.loss = BatchLoss::kNone;
    const InertialBatchResult result = smooth(scene.input, name(), settings);
    const Estimate& m = result.estimates.back();
    const Eigen::VectorXd e = motion_error(scene.truth.back().state, m);
    poses += e.head<6>().dot(m.covariance.topLeftCorner<6, 6>().ldlt().solve(e.head<6>()));
    states += e.dot(m.covariance.ldlt().solve(e));
  }
  EXPECT_TRUE(test::is_chi2(poses, 6 * runs));
  EXPECT_TRUE(test::is_chi2(states, 15 * runs));
}

TEST_P(Batch, TheSameBytesEveryTime) {
  const SmallScene scene = small_scene({.frames = 40});  // many enough for the sparse solver
  const InertialBatchResult a = smooth(scene.input, name(), {}),
                            b = smooth(scene.input, name(), {});
  ASSERT_EQ(a.estimates.size(), b.estimates.size());
  for (std::size_t k = 0; k < a.estimates.size(); ++k) {
    EXPECT_EQ(a.estimates[k].world_T_imu.p, b.estimates[k].world_T_imu.p);
    EXPECT_EQ(a.estimates[k].covariance, b.estimates[k].covariance);
  }
  EXPECT_EQ(a.report.costs, b.report.costs);
}

INSTANTIATE_TEST_SUITE_P(Charts, Batch, ::testing::ValuesIn(test::all_charts()),
                         test::chart_test_name);

TEST(BatchSolvers, FindTheSame) {
  const SmallScene scene = small_scene({.frames = 15});
  BatchSettings settings = exact();
  std::vector<InertialBatchResult> results;
  for (const BatchSolver solver :
       {BatchSolver::kDenseSchur, BatchSolver::kSparseSchur, BatchSolver::kSparseNormal}) {
    settings.solver = solver;
    results.push_back(smooth(scene.input, "standard", settings));
    EXPECT_EQ(results.back().report.solver, solver);
    for (std::size_t k = 0; k < results.front().estimates.size(); ++k) {
      EXPECT_LT(
          (results.back().estimates[k].world_T_imu.p - results.front().estimates[k].world_T_imu.p)
              .norm(),
          1e-7);
    }
  }
}

TEST(BatchLoss, WrongPixelsHardlyMatter) {
  SmallScene scene = small_scene({.frames = 12, .cameras = 2});
  const InertialBatchResult clean = smooth(scene.input, "standard", {});
  for (std::size_t k = 1; k < scene.input.frames.size(); k += 3) {
    scene.input.frames[k].pixels[k].pixel += Eigen::Vector2d(40, -25);
  }
  const auto distance = [&](const InertialBatchResult& result) {
    return (result.estimates.back().world_T_imu.p - clean.estimates.back().world_T_imu.p).norm();
  };
  BatchSettings trusting;
  trusting.loss = BatchLoss::kNone;
  trusting.gate = 0;
  const double trusted = distance(smooth(scene.input, "standard", trusting));
  for (const BatchLoss loss : {BatchLoss::kHuber, BatchLoss::kCauchy}) {
    BatchSettings settings;
    settings.loss = loss;
    settings.gate = 0;
    const InertialBatchResult result = smooth(scene.input, "standard", settings);
    EXPECT_LT(distance(result), 0.5 * trusted) << name_of(loss);
    EXPECT_GE(result.report.outliers, 4);
  }
}

TEST(BatchGate, WrongPixelsAreLeftOutAndTheirLandmarksStay) {
  for (const LandmarkForm landmarks : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    SmallScene scene = small_scene({.frames = 12, .cameras = 2});
    BatchSettings settings;
    settings.landmarks = landmarks;
    const InertialBatchResult clean = smooth(scene.input, "standard", settings);
    EXPECT_EQ(clean.report.gated, 0);
    // The first observation of one landmark, its anchor, and some later ones.
    scene.input.frames[0].pixels[0].pixel += Eigen::Vector2d(60, 20);
    for (const std::size_t k : {3u, 5u, 8u}) {
      scene.input.frames[k].pixels[k].pixel += Eigen::Vector2d(40, -25);
    }
    const InertialBatchResult result = smooth(scene.input, "standard", settings);
    EXPECT_GE(result.report.gated, 4) << name_of(landmarks);
    EXPECT_LT(result.report.gated, 10) << name_of(landmarks);
    EXPECT_NEAR(result.report.cost_per_dof, clean.report.cost_per_dof, 0.05);
    EXPECT_EQ(result.report.landmarks, clean.report.landmarks);
    EXPECT_EQ(result.report.observations + result.report.gated, clean.report.observations);
    EXPECT_LT((result.estimates.back().world_T_imu.p - clean.estimates.back().world_T_imu.p).norm(),
              0.003);
  }
}

// Tracks that drift to a neighbouring point and stay there: the mean of both fits neither.
void slide(SmallScene& scene) {
  for (std::size_t k = 0; k < scene.input.frames.size(); ++k) {
    for (PixelObservation& o : scene.input.frames[k].pixels) {
      if (o.landmark % 4 != 0) o.pixel.x() += k < 9 ? -1.8 : k < 15 ? 25.0 : 1.8;
    }
  }
}

double position_error(const SmallScene& scene, const InertialBatchResult& result) {
  double sum = 0;
  for (std::size_t k = 0; k < scene.truth.size(); ++k) {
    sum += (result.estimates[k].world_T_imu.p - scene.truth[k].state.world_T_imu.p).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(scene.truth.size()));
}

TEST(BatchGate, ATrackThatSlidesOffIsAnotherPointBehind) {
  for (const LandmarkForm landmarks : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    SmallScene scene = small_scene({.frames = 24, .landmarks = 40});
    BatchSettings settings;
    settings.landmarks = landmarks;
    const InertialBatchResult clean = smooth(scene.input, "standard", settings);
    slide(scene);
    const InertialBatchResult split = smooth(scene.input, "standard", settings);
    settings.max_rejections = 100;
    const InertialBatchResult whole = smooth(scene.input, "standard", settings);
    EXPECT_EQ(whole.report.landmarks_split, 0);
    EXPECT_EQ(whole.report.landmarks, clean.report.landmarks);
    EXPECT_GT(split.report.landmarks_split, 10) << name_of(landmarks);
    EXPECT_EQ(split.report.landmarks, clean.report.landmarks + split.report.landmarks_split);
    EXPECT_NEAR(split.report.cost_per_dof, clean.report.cost_per_dof, 0.1);
    EXPECT_GT(whole.report.cost_per_dof, 1.2 * clean.report.cost_per_dof);
    EXPECT_LT(position_error(scene, split), 1.4 * position_error(scene, clean));
    EXPECT_GT(position_error(scene, whole), 1.6 * position_error(scene, split));
  }
}

TEST(BatchGate, WithTwoCamerasTooAndNothingIsLostOnTheWay) {
  for (const LandmarkForm landmarks : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    SmallScene scene = small_scene({.frames = 24, .cameras = 2, .landmarks = 40});
    BatchSettings settings;
    settings.landmarks = landmarks;
    const InertialBatchResult clean = smooth(scene.input, "standard", settings);
    slide(scene);
    const InertialBatchResult result = smooth(scene.input, "standard", settings);
    const BatchReport& report = result.report;
    EXPECT_GT(report.landmarks_split, 10) << name_of(landmarks);
    EXPECT_EQ(report.observations + report.gated, clean.report.observations);
    int of_frames = 0, of_landmarks = 0;
    for (const Estimate& m : result.estimates) of_frames += m.observations;
    for (const MapLandmark& l : result.landmarks) of_landmarks += l.observations;
    EXPECT_EQ(of_frames, report.observations);
    EXPECT_EQ(of_landmarks, report.observations);
    EXPECT_EQ(std::ssize(result.landmarks), report.landmarks);
    EXPECT_FALSE(report.stalled);
  }
}

// One or two observations after it do not determine a depth: they are no landmark.
TEST(BatchGate, ATailWithoutParallaxIsNoLandmark) {
  for (const LandmarkForm landmarks : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    SmallScene scene = small_scene({.frames = 24});
    for (std::size_t k = 15; k < 22; ++k) {
      for (PixelObservation& o : scene.input.frames[k].pixels) {
        if (o.landmark < 105) o.pixel.y() += 30;
      }
    }
    BatchSettings settings;
    settings.landmarks = landmarks;
    settings.min_parallax = 0.2;
    const InertialBatchResult result = smooth(scene.input, "standard", settings);
    EXPECT_GT(result.report.gated, 20);
    EXPECT_EQ(result.report.landmarks_split, 0) << name_of(landmarks);
    EXPECT_FALSE(result.report.stalled);
    for (const MapLandmark& l : result.landmarks) EXPECT_TRUE(l.covariance.allFinite());
  }
}

// Tracks with random pixels.
TEST(BatchSearch, WrongTracksDoNotHoldItUp) {
  for (const LandmarkForm landmarks : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    SmallScene scene = small_scene({.frames = 12});
    BatchSettings settings;
    settings.landmarks = landmarks;
    const InertialBatchResult clean = smooth(scene.input, "standard", settings);
    test::Random random(6);
    for (int track = 0; track < 40; ++track) {
      for (std::size_t k = 0; k < 4; ++k) {
        scene.input.frames[2 * k + static_cast<std::size_t>(track % 5)].pixels.push_back(
            {.landmark = 1000 + track, .pixel = {random.uniform(0, 640), random.uniform(0, 480)}});
      }
    }
    const InertialBatchResult result = smooth(scene.input, "standard", settings);
    EXPECT_TRUE(result.report.converged) << name_of(landmarks);
    EXPECT_FALSE(result.report.stalled)
        << name_of(landmarks) << ": " << result.report.decrease_left;
    EXPECT_LT((result.estimates.back().world_T_imu.p - clean.estimates.back().world_T_imu.p).norm(),
              0.01);
  }
}

TEST(BatchKeyframes, EveryNthFrame) {
  const SmallScene scene = small_scene({.frames = 13});
  BatchSettings settings;
  settings.frames_per_keyframe = 4;
  const InertialBatchResult result = smooth(scene.input, "right-sen3", settings);
  ASSERT_EQ(result.estimates.size(), 4u);
  EXPECT_EQ(result.estimates[2].time, scene.input.frames[8].time);
  EXPECT_LT(motion_error(scene.truth[12].state, result.estimates[3]).segment<3>(3).norm(), 0.1);
}

TEST(BatchTracks, ALandmarkThatComesBackIsTheSameOrNot) {
  SmallScene scene = small_scene({.frames = 12});
  for (std::size_t k = 4; k < 8; ++k) {
    std::erase_if(scene.input.frames[k].pixels,
                  [](const PixelObservation& o) { return o.landmark < 110; });
  }
  BatchSettings settings;
  const int all = smooth(scene.input, "standard", settings).report.landmarks;
  settings.loops = false;
  EXPECT_GT(smooth(scene.input, "standard", settings).report.landmarks, all);
}

// Each camera has every second frame, and its tracks do not end in those of the other.
TEST(BatchTracks, CamerasMayTakeTurns) {
  SmallScene scene = small_scene({.frames = 12});
  scene.input.cameras.push_back(scene.input.cameras[0]);
  for (std::size_t k = 0; k < scene.input.frames.size(); ++k) {
    for (PixelObservation& o : scene.input.frames[k].pixels) {
      o.camera = k % 2 == 0 ? 0 : 1;
      o.landmark = 2 * o.landmark + o.camera;
    }
  }
  BatchSettings settings;
  const int all = smooth(scene.input, "standard", settings).report.landmarks;
  settings.loops = false;
  EXPECT_EQ(smooth(scene.input, "standard", settings).report.landmarks, all);
}

// Stars: with noise, about half of their inverse depths are negative.
TEST(BatchTracks, DirectionsBeyondInfinityHaveNoPlace) {
  SmallScene scene = small_scene({.frames = 12, .landmarks = 30});
  BatchSettings settings;
  settings.landmarks = LandmarkForm::kInverseDepth;
  settings.min_parallax = 0;
  const int near = smooth(scene.input, "right-sen3", settings).report.landmarks;
  test::Random random(3);
  for (FeatureFrame& frame : scene.input.frames) {
    const InertialState& state =
        scene.truth[static_cast<std::size_t>(&frame - scene.input.frames.data())].state;
    const Camera& camera = scene.input.cameras[0];
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d star = scene.truth.front().state.world_T_imu.R *
                                   Eigen::Vector3d(1, 0.05 * (i % 5 - 2), 0.06 * (i / 5 - 2));
      const auto seen =
          project(camera, camera.cam_T_imu.R * (state.world_T_imu.R.transpose() * star));
      ASSERT_TRUE(seen);
      frame.pixels.push_back({.landmark = 1000 + i,
                              .camera = 0,
                              .pixel = seen->pixel + scene.input.pixel_sigma *
                                                         Eigen::Vector2d(random.normal_vector(2))});
    }
  }
  const InertialBatchResult result = smooth(scene.input, "right-sen3", settings);
  const Eigen::Vector3d p_start = scene.truth.front().state.world_T_imu.p;
  int stars = 0;
  for (const MapLandmark& l : result.landmarks) {
    ASSERT_TRUE(l.p_world.allFinite() && l.covariance.allFinite());
    if (l.id < 1000) continue;
    ++stars;
    // In front of the camera, and not beside it.
    EXPECT_GT((scene.truth.front().state.world_T_imu.R.transpose() * (l.p_world - p_start)).x(), 5);
  }
  EXPECT_EQ(result.report.landmarks, near + 20);
  EXPECT_GT(stars, 2);
  EXPECT_LT(stars, 18);
  EXPECT_LT(motion_error(scene.truth.back().state, result.estimates.back()).segment<3>(3).norm(),
            0.1);
}

TEST(BatchCovariance, IsThatOfIndependentErrorsTimesTheFactor) {
  for (const int cameras : {1, 2}) {
    test::SmallScene scene = test::small_scene({.frames = 24, .cameras = cameras, .noise = 0.1});
    test::let_walk(scene, 1);
    BatchSettings settings = exact(LandmarkForm::kInverseDepth);
    settings.gate = 0;
    const InertialBatchResult plain = smooth(scene.input, "standard", settings);
    EXPECT_EQ(plain.report.covariance_factor, 1);
    for (const std::optional<double> stated :
         {std::optional<double>(), std::optional(3.0), std::optional(0.5)}) {
      settings.covariance_factor = stated;
      const InertialBatchResult wide = smooth(scene.input, "standard", settings);
      const double factor = wide.report.covariance_factor;
      if (stated) {
        EXPECT_EQ(factor, *stated);
      } else {
        EXPECT_GT(factor, 2);
      }
      ASSERT_EQ(wide.estimates.size(), plain.estimates.size());
      for (std::size_t k = 0; k < plain.estimates.size(); ++k) {
        EXPECT_EQ(wide.estimates[k].world_T_imu.p, plain.estimates[k].world_T_imu.p);
        EXPECT_TRUE(
            wide.estimates[k].covariance.isApprox(factor * plain.estimates[k].covariance, 1e-14));
      }
      ASSERT_EQ(wide.landmarks.size(), plain.landmarks.size());
      for (std::size_t i = 0; i < plain.landmarks.size(); ++i) {
        EXPECT_TRUE(
            wide.landmarks[i].covariance.isApprox(factor * plain.landmarks[i].covariance, 1e-14));
      }
      EXPECT_EQ(wide.report.unobservable, plain.report.unobservable);
    }
  }
}

TEST(BatchCovariance, WhiteNoiseDoesNotWidenIt) {
  int widened = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const test::SmallScene scene = test::small_scene({.frames = 24, .cameras = 2, .seed = seed});
    widened += smooth(scene.input, "standard", {}).report.covariance_factor > 1 ? 1 : 0;
  }
  EXPECT_LE(widened, 1);
}

}  // namespace
}  // namespace chasles
