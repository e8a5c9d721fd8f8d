#include <cmath>
#include <filesystem>
#include <iterator>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/filter/testing.hpp>
#include <chasles/smooth/batch/exact_settings_testing.hpp>
#include <chasles/smooth/batch/velocity_oracle_testing.hpp>
#include <chasles/smooth/batch/velocity_problem_detail.hpp>

namespace chasles {
namespace {

using test::drive_error;
using test::drive_scene;
using test::DriveScene;
using test::SmallDrive;

BatchSettings exact_velocity_batch(LandmarkForm landmarks = LandmarkForm::kCartesian) {
  return test::exact_settings(landmarks);
}

std::string rejection(const VelocityBatchInput& input, const BatchSettings& settings = {}) {
  try {
    smooth(input, settings);
  } catch (const Error& e) {
    return e.what();
  }
  return "nothing was rejected";
}

// Every kind of motion and of rows once.
std::vector<SmallDrive> kinds() {
  return {{.frames = 5, .landmarks = 10},
          {.frames = 4, .scale = true, .rows = StereoRows::kMean, .landmarks = 8, .seed = 2},
          {.frames = 4, .scale = true, .level = true, .landmarks = 8, .seed = 4},
          {.frames = 5,
           .velocity = VelocityRole::kInput,
           .scale = true,
           .rows = StereoRows::kAll,
           .landmarks = 8,
           .seed = 3}};
}

class VelocityBatch : public test::OverCharts {
 protected:
  DriveScene scene(const SmallDrive& drive) const {
    DriveScene s = drive_scene(drive);
    s.input.settings.chart = std::string(chart().name);
    return s;
  }
};

TEST_P(VelocityBatch, IsTheMinimumThatADenseGaussNewtonFinds) {
  for (const SmallDrive& kind : kinds()) {
    const DriveScene s = scene(kind);
    test::VelocityOracle oracle(s);
    oracle.solve(6);
    const Eigen::MatrixXd P = oracle.inverse();
    const int n = oracle.state_size();
    for (const LandmarkForm landmarks : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
      const VelocityBatchResult result = smooth(s.input, exact_velocity_batch(landmarks));
      ASSERT_EQ(result.estimates.size(), oracle.states().size());
      EXPECT_NEAR(result.report.final_cost / oracle.cost(), 1, 1e-6);
      for (std::size_t k = 0; k < result.estimates.size(); ++k) {
        const Estimate& e = result.estimates[k];
        EXPECT_LT(drive_error(oracle.states()[k], e).cwiseAbs().maxCoeff(), 1e-6) << k;
        const Eigen::MatrixXd Pk = P.block(n * static_cast<int>(k), n * static_cast<int>(k), n, n);
        EXPECT_LT(test::covariance_difference(e.pose_covariance(), Pk.topLeftCorner(6, 6)), 1e-4);
        const Eigen::VectorXd sigma = Pk.diagonal().tail(n - 6).cwiseSqrt();
        EXPECT_LT((e.additive_sigma().cwiseQuotient(sigma).array() - 1).abs().maxCoeff(), 1e-4);
      }
      Eigen::Index at = n * std::ssize(result.estimates);
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

TEST_P(VelocityBatch, WithoutNoiseFindsTheTruthFromABadBeginning) {
  DriveScene s = scene({.frames = 12, .noise = 0, .samples_a_frame = 2});
  test::Random random(7);
  for (const test::TrueDrive& t : s.truth) {
    Estimate& e = s.input.initial.emplace_back();
    e.time = t.time;
    e.world_T_imu.R = so3::exp(0.05 * random.normal_vector(3)) * t.world_T_imu.R;
    e.world_T_imu.p = t.world_T_imu.p + 0.3 * random.normal_vector(3);
    e.additive = t.additive + 0.1 * random.normal_vector(t.additive.size());
  }
  for (const LandmarkForm landmarks : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    const VelocityBatchResult result = smooth(s.input, exact_velocity_batch(landmarks));
    EXPECT_TRUE(result.report.converged) << result.report.end;
    ASSERT_EQ(result.estimates.size(), s.truth.size());
    EXPECT_EQ(result.report.keyframes, 23);  // a sample between two frames is an instant too
    for (std::size_t k = 0; k < s.truth.size(); ++k) {
      EXPECT_LT(drive_error(s.truth[k], result.estimates[k]).norm(), 1e-5);
    }
    for (const MapLandmark& l : result.landmarks) {
      EXPECT_LT((l.p_world - s.landmarks.at(l.id)).norm(), 1e-4);
    }
  }
}

TEST_P(VelocityBatch, KnowsHowWrongItIs) {
  for (const VelocityRole velocity : {VelocityRole::kMeasured, VelocityRole::kInput}) {
    double first = 0, last = 0, additive = 0;
    int runs = 0, additive_dof = 0;
    for (; runs < 40; ++runs) {
      const DriveScene s =
          scene({.velocity = velocity, .seed = 100 + static_cast<std::uint64_t>(runs)});
      const VelocityBatchResult result =
          smooth(s.input, exact_velocity_batch(LandmarkForm::kInverseDepth));
      const auto nees = [&](std::size_t k) {
        const Estimate& e = result.estimates[k];
        const Eigen::VectorXd d = drive_error(s.truth[k], e);
        return d.head<6>().dot(e.pose_covariance().ldlt().solve(d.head<6>()));
      };
      first += nees(1);
      last += nees(s.truth.size() - 1);
      const Estimate& e = result.estimates.back();
      const Eigen::VectorXd d = drive_error(s.truth.back(), e);
      additive +=
          std::pow(d[6] / e.additive_sigma()[0], 2);  // only one of them: they are correlated
      ++additive_dof;
    }
    EXPECT_TRUE(test::is_chi2(first, 6 * runs));
    EXPECT_TRUE(test::is_chi2(last, 6 * runs));
    EXPECT_TRUE(test::is_chi2(additive, additive_dof));
  }
}

TEST_P(VelocityBatch, KnowsHowWrongItIsOfLevelVelocities) {
  double pose = 0, tilt = 0;
  constexpr int kRuns = 40;
  for (int run = 0; run < kRuns; ++run) {
    const DriveScene s = scene({.level = true, .seed = 200 + static_cast<std::uint64_t>(run)});
    const Estimate e =
        smooth(s.input, exact_velocity_batch(LandmarkForm::kInverseDepth)).estimates.back();
    const Eigen::VectorXd d = drive_error(s.truth.back(), e);
    pose += d.head<6>().dot(e.pose_covariance().ldlt().solve(d.head<6>()));
    const Eigen::Index at = d.size() - 3;
    tilt += std::pow(d[at] / e.additive_sigma()[at - 6], 2);
  }
  EXPECT_TRUE(test::is_chi2(pose, 6 * kRuns));
  EXPECT_TRUE(test::is_chi2(tilt, kRuns));
}

TEST_P(VelocityBatch, TheSameBytesEveryTime) {
  const DriveScene s = scene({.frames = 40});  // many enough for the sparse solver
  const VelocityBatchResult a = smooth(s.input, {}), b = smooth(s.input, {});
  ASSERT_EQ(a.estimates.size(), b.estimates.size());
  for (std::size_t k = 0; k < a.estimates.size(); ++k) {
    EXPECT_EQ(a.estimates[k].world_T_imu.p, b.estimates[k].world_T_imu.p);
    EXPECT_EQ(a.estimates[k].pose_covariance(), b.estimates[k].pose_covariance());
  }
  EXPECT_EQ(a.report.costs, b.report.costs);
}

INSTANTIATE_TEST_SUITE_P(Charts, VelocityBatch, ::testing::ValuesIn(test::all_charts()),
                         test::chart_test_name);

// With the same data the filter has larger errors, on average.
TEST(VelocityBatchAndFilter, TheBatchErrsLess) {
  double filter = 0, batch = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    DriveScene s = drive_scene({.frames = 20, .seed = seed});
    s.input.settings.gate = 1;
    VelocitySlam slam(s.input.settings, s.input.rig, s.input.noise);
    for (std::size_t k = 0; k < s.truth.size(); ++k) {
      slam.process(s.input.velocities[k]);
      s.input.initial.push_back(slam.process(s.input.frames[k]));
    }
    const VelocityBatchResult result = smooth(s.input, exact_velocity_batch());
    for (std::size_t k = 0; k < s.truth.size(); ++k) {
      const auto error = [&](const Estimate& e) {
        return (e.world_T_imu.p - s.truth[k].world_T_imu.p).squaredNorm();
      };
      filter += error(s.input.initial[k]);
      batch += error(result.estimates[k]);
    }
  }
  EXPECT_LT(batch, 0.9 * filter);
}

TEST(VelocityBatchGate, WrongPixelsAreLeftOutAndTheirLandmarksStay) {
  for (const LandmarkForm landmarks : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    DriveScene s = drive_scene({.frames = 12});
    BatchSettings settings;
    settings.landmarks = landmarks;
    const VelocityBatchResult clean = smooth(s.input, settings);
    EXPECT_EQ(clean.report.gated, 0);
    // The first observation of one landmark, its anchor, and some later ones.
    s.input.frames[0].observations[0].pixels += Eigen::Vector4d(15, 5, 15, 5);
    for (const std::size_t k : {3u, 5u, 8u}) {
      s.input.frames[k].observations[k].pixels += Eigen::Vector4d(40, -25, 40, -25);
    }
    const VelocityBatchResult result = smooth(s.input, settings);
    EXPECT_GE(result.report.gated, 4) << name_of(landmarks);
    EXPECT_LT(result.report.gated, 10) << name_of(landmarks);
    EXPECT_NEAR(result.report.cost_per_dof, clean.report.cost_per_dof, 0.06);
    EXPECT_EQ(result.report.landmarks, clean.report.landmarks);
    EXPECT_LT((result.estimates.back().world_T_imu.p - clean.estimates.back().world_T_imu.p).norm(),
              0.02);
  }
}

TEST(VelocityBatchGate, WhereNothingAgreesThereIsNoAnswer) {
  DriveScene s = drive_scene();
  BatchSettings settings;
  settings.gate = 1e-6;
  EXPECT_NE(rejection(s.input, settings).find("batch.gate"), std::string::npos);
}

TEST(VelocityBatchTracks, ALandmarkThatComesBackIsTheSameOrNot) {
  DriveScene s = drive_scene({.frames = 12});
  for (std::size_t k = 4; k < 8; ++k) {
    std::erase_if(s.input.frames[k].observations,
                  [](const StereoObservation& o) { return o.landmark < 110; });
  }
  BatchSettings settings;
  EXPECT_EQ(smooth(s.input, settings).report.landmarks, 20);
  settings.loops = false;
  EXPECT_EQ(smooth(s.input, settings).report.landmarks, 30);
}

TEST(VelocityBatchTracks, ALandmarkBeginsWhereItHasADisparity) {
  DriveScene s = drive_scene({.frames = 6});
  StereoObservation& first = s.input.frames[0].observations[0];
  first.pixels[2] = first.pixels[0] + 1;  // beyond infinity
  const VelocityBatchResult result = smooth(s.input, {});
  EXPECT_EQ(result.report.landmarks, 20);
  EXPECT_EQ(result.report.observations, 6 * 20 - 1);
  const auto found = std::ranges::find(result.landmarks, first.landmark, &MapLandmark::id);
  ASSERT_NE(found, result.landmarks.end());
  EXPECT_LT((found->p_world - s.landmarks.at(first.landmark)).norm(), 3);
}

TEST(VelocityBatchKeyframes, EveryNthFrame) {
  const DriveScene s = drive_scene({.frames = 13});
  BatchSettings settings;
  settings.frames_per_keyframe = 4;
  const VelocityBatchResult result = smooth(s.input, settings);
  ASSERT_EQ(result.estimates.size(), 4u);
  EXPECT_EQ(result.estimates[2].time, s.input.frames[8].time);
  EXPECT_LT(drive_error(s.truth[12], result.estimates[3]).segment<3>(3).norm(), 0.2);
}

// CHOLMOD would create three more, if it uses OpenMP.
TEST(VelocityBatchThreads, NoneAreMade) {
  const auto threads = [] {
    return std::distance(std::filesystem::directory_iterator("/proc/self/task"), {});
  };
  const DriveScene s = drive_scene({.frames = 60, .landmarks = 60});
  const auto before = threads();
  const VelocityBatchResult result = smooth(s.input, {});
  EXPECT_EQ(result.report.solver, BatchSolver::kSparseNormal);
  EXPECT_EQ(threads(), before);
}

TEST(VelocityBatchBadInput, IsRecoveredAndCounted) {
  DriveScene s = drive_scene({.frames = 12});
  auto& frames = s.input.frames;
  frames[3].observations[0].pixels[1] = std::nan("");
  frames[5].observations.push_back(frames[5].observations[2]);  // twice: the first one counts
  const VelocityBatchResult result = smooth(s.input, {});
  EXPECT_EQ(result.report.unusable, 2);
  EXPECT_LT(drive_error(s.truth.back(), result.estimates.back()).segment<3>(3).norm(), 0.2);
}

TEST(VelocityBatchBadInput, NothingToEstimateFromIsRejected) {
  const DriveScene s = drive_scene();
  const auto rejected = [&](const char* words, const auto& spoil) {
    VelocityBatchInput input = s.input;
    spoil(input);
    const std::string text = rejection(input);
    EXPECT_NE(text.find(words), std::string::npos) << text;
  };
  rejected("two frames", [](VelocityBatchInput& in) { in.frames.clear(); });
  rejected("landmarks that are observed twice", [](VelocityBatchInput& in) {
    for (FeatureFrame& frame : in.frames) frame.observations.clear();
  });
  rejected("needs velocities", [](VelocityBatchInput& in) { in.velocities.clear(); });
  rejected("not finite",
           [](VelocityBatchInput& in) { in.velocities[2].linear_imu.x() = std::nan(""); });
  rejected("time runs backwards",
           [](VelocityBatchInput& in) { std::swap(in.frames[2], in.frames[5]); });
  rejected("pixel_sigma", [](VelocityBatchInput& in) { in.noise.update.v = 0; });
  rejected("velocity_sigma", [](VelocityBatchInput& in) { in.noise.motion.sample_sigma[4] = 0; });
  rejected("velocity_walk", [](VelocityBatchInput& in) { in.noise.motion.walk[4] = 0; });
  rejected("--mode slam", [](VelocityBatchInput& in) { in.settings.mode = SlamMode::kMap; });
  rejected("initial_landmark_sigma",
           [](VelocityBatchInput& in) { in.settings.initial_landmark_sigma = 0.1; });
  rejected("polar", [](VelocityBatchInput& in) { in.settings.chart = "polar"; });
}

TEST(VelocityBatchBadInput, SettingsThatCannotBeUsedAreRejected) {
  DriveScene s = drive_scene();
  EXPECT_EQ(rejection(s.input, {.solver = BatchSolver{7}}).find("batch.solver: found"), 0U);
  EXPECT_EQ(rejection(s.input, {.chart = "other"}).find("batch.chart: found 'other'"), 0U);
  s.input.settings.stereo_rows = StereoRows{7};
  EXPECT_EQ(rejection(s.input, {}).find("stereo_rows: found"), 0U);
}

// Velocities without information, and pixels too coarse to determine the motion.
TEST(VelocityBatchLoss, IsNarrowWhereTheNoiseOfPixelsWasMeasured) {
  DriveScene s = drive_scene();
  EXPECT_EQ(smooth(s.input, {}).report.loss_width, 2.5);
  s.input.noise.pixels_inflated = true;
  const BatchReport measured = smooth(s.input, {}).report;
  EXPECT_EQ(measured.loss_width, 0.5);
  EXPECT_EQ(smooth(s.input, {.loss_width = 1.5}).report.loss_width, 1.5);
  // The fit is assessed with the usual width.
  s.input.noise.initialisation = s.input.noise.update = {.u = 0.05, .v = 0.05, .disparity = 0.05};
  EXPECT_GT(smooth(s.input, {.gate = 0}).report.cost_per_dof, 2);
  EXPECT_LT(measured.cost_per_dof, 1.3);
}

TEST(VelocityBatchIllPosed, IsNamedNotAnswered) {
  DriveScene s = drive_scene({.noise = 0});
  s.input.noise.motion.sample_sigma.setConstant(1e4);
  s.input.noise.motion.walk.setConstant(1e4);
  s.input.noise.initialisation = s.input.noise.update = {.u = 1e4, .v = 1e4, .disparity = 1e4};
  EXPECT_NE(rejection(s.input).find("ill-posed"), std::string::npos);
}

TEST(VelocityBatchIllPosed, NamesALandmarkThatNoPixelObserves) {
  const DriveScene s = drive_scene();
  const BatchSettings settings = exact_velocity_batch();
  VelocityBatchResult result;
  smooth_detail::VelocityGraph graph =
      smooth_detail::velocity_graph(s.input, settings, result.report);
  ASSERT_EQ(graph.points[3].id, 103);
  graph.points[3].parameters = {-50, 0, 0};  // metres behind the start of the run
  smooth_detail::VelocityProblem problem(s.input, settings, graph, smooth_detail::kLeastDepth);
  try {
    add_estimates(problem, s.input, graph, result);
    FAIL() << "nothing was rejected";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kDiverged);
    EXPECT_NE(std::string(e.what()).find("no pixel of landmark 103 constrains its position (the "
                                         "same holds for 1 of 20 landmarks)"),
              std::string::npos)
        << e.what();
  }
}

}  // namespace
}  // namespace chasles
