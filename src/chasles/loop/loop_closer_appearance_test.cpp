#include <Eigen/LU>

#include <chasles/loop/recognition_testing.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using test::can_return;
using test::index_of;
using test::kScenePoints;
using test::matched_ids;
using test::SceneRun;
using test::TexturedScene;

// The pairs are the true ones. The landmarks return with the covariance with which they would have
// stayed, and the error of another point across their rays, of 1.5 px.
TEST(LoopCloserAppearance, LandmarksReturnThatLookAsTheyDid) {
  const TexturedScene scene(1);
  SceneRun run(scene), stayed(scene);
  run.come_back();
  stayed.come_back(false);
  const FeatureFrame frame = run.frame(101);
  auto found = run.search(frame);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->by_appearance());
  EXPECT_FALSE(found->of_map);
  const auto matches = matched_ids(*found);
  ASSERT_GE(matches.size(), 3u);
  for (const auto& [track, landmark] : matches) EXPECT_EQ(track - 101, landmark - 1);
  EXPECT_FALSE(run.closer.awaits(1)) << "not by its id";
  EXPECT_EQ(run.closer.recognised(), std::vector{run.at.by_imu});

  const State& other = stayed.filter.state();
  std::vector<Measurement> all;
  for (const auto& [track, landmark] : matches) {
    const auto& pixel = frame.pixels[static_cast<std::size_t>(track - 101)].pixel;
    all.push_back(*measure_pixel(scene.camera, 1, other, index_of(stayed.filter, landmark), pixel));
  }
  const auto z = test::dense_measurement(other, all);
  const MatrixXd P_stayed = stayed.filter.covariance();
  const MatrixXd S =
      z.H * P_stayed * z.H.transpose() + 3.25 * MatrixXd::Identity(z.r.size(), z.r.size());
  const double square = z.r.dot(S.inverse() * z.r);

  run.closer.close(*found, run.filter, run.records, run.at);
  ASSERT_EQ(run.closer.closures().size(), 1u);
  const Closure& closure = run.closer.closures().front();
  EXPECT_EQ(closure.time, run.at.by_imu);
  EXPECT_EQ(closure.landmarks, std::ssize(matches));
  EXPECT_EQ(closure.dof, 2 * std::ssize(matches));
  EXPECT_NEAR(closure.square, square, 1e-6 * square);
  const State& x = run.filter.state();
  const MatrixXd P = run.filter.covariance();
  ASSERT_EQ(x.landmarks.size(), static_cast<std::size_t>(kScenePoints));
  EXPECT_EQ(run.records.size(), x.landmarks.size());
  EXPECT_EQ(run.records.back().seen, run.at.frame);
  std::vector<LandmarkId> returned;
  for (const auto& [track, landmark] : matches) {
    returned.push_back(landmark);
    const int index = index_of(run.filter, landmark), old = index_of(stayed.filter, landmark);
    const int at = x.landmarks[static_cast<std::size_t>(index)].row;
    const int before = other.landmarks[static_cast<std::size_t>(old)].row;
    EXPECT_TRUE(test::agree(P.block(at, 0, 3, 15), P_stayed.block(before, 0, 3, 15), 1e-9));
    EXPECT_EQ(index_of(run.filter, track), kScenePoints) << "its track continues as the landmark";
    const MatrixXd noise = P.block<3, 3>(at, at) - P_stayed.block<3, 3>(before, before);
    const Vector3d ray = x.landmarks[static_cast<std::size_t>(index)].p_world -
                         (x.world_T_imu * scene.camera.cam_T_imu.inverse()).p;
    const double angle = 1.5 / scene.camera.fx;
    EXPECT_TRUE(test::agree(
        noise,
        angle * angle * (ray.squaredNorm() * Eigen::Matrix3d::Identity() - ray * ray.transpose()),
        1e-6));
  }
  EXPECT_TRUE(std::ranges::equal(run.closer.returned(), returned));
}

// The update that follows corrects the drift, and the covariance says how well.
TEST(LoopCloserAppearance, TheirReturnCorrectsThePose) {
  SceneRun run(TexturedScene(2));
  run.come_back();
  const FeatureFrame frame = run.frame(101);
  auto found = run.search(frame);
  ASSERT_TRUE(found);
  run.closer.close(*found, run.filter, run.records, run.at);
  const SE3 before = run.filter.state().world_T_imu;
  const MatrixXd P_before = run.filter.core_covariance().block<3, 3>(3, 3);
  run.observe(run.closer.renamed(frame));
  const SE3 after = run.filter.state().world_T_imu;
  run.closer.note_change(before, after);
  const Closure& closure = run.closer.closures().front();
  EXPECT_NEAR(closure.moved, (after.p - before.p).norm(), 1e-12);
  EXPECT_NEAR(closure.turned, so3::log(after.R * before.R.transpose()).norm(), 1e-12);
  const Vector3d error = run.scene_T_imu.p - after.p;
  const MatrixXd P = run.filter.core_covariance().block<3, 3>(3, 3);
  EXPECT_LT(P.trace(), 0.5 * P_before.trace());
  EXPECT_LT(error.dot(P.inverse() * error), 16.3) << "chi2 of 3 with probability 0.999";
}

TEST(LoopCloserAppearance, RecognisedTracksContinueUnderTheFirstIds) {
  SceneRun run(TexturedScene(3));
  run.come_back();
  const FeatureFrame frame = run.frame(101);
  EXPECT_EQ(run.closer.renamed(frame).data(), frame.pixels.data()) << "so far none";
  auto found = run.search(frame);
  ASSERT_TRUE(found);
  const auto matches = matched_ids(*found);
  run.closer.close(*found, run.filter, run.records, run.at);
  EXPECT_EQ(run.closer.known_as().size(), matches.size());
  const auto renamed = run.closer.renamed(frame);
  ASSERT_EQ(renamed.size(), frame.pixels.size());
  for (std::size_t i = 0; i < renamed.size(); ++i) {
    const LandmarkId track = frame.pixels[i].landmark;
    const auto match = std::ranges::find(matches, track, [](const auto& m) { return m.first; });
    EXPECT_EQ(renamed[i].landmark, match == matches.end() ? track : match->second);
    EXPECT_EQ(&run.closer.original(frame, renamed[i]), &frame.pixels[i]);
  }
  // A landmark that the gate rejects is no longer known by that track.
  const auto [track, landmark] = matches.front();
  const int index = index_of(run.filter, landmark);
  run.records[static_cast<std::size_t>(index)].rejected = 5;
  run.leave({index});
  EXPECT_TRUE(std::ranges::equal(run.closer.rejected(), std::array{landmark}));
  EXPECT_FALSE(run.closer.known_as().contains(track));
}

// At most every 0.3 s, in an image, and from two places.
TEST(LoopCloserAppearance, SearchesNowAndThenAndFromTwoPlaces) {
  SceneRun run(TexturedScene(1));
  run.initialise(1);
  run.search(1);
  run.all_leave();
  run.move({0, 0.3, 0});
  run.initialise(101);
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(run.search(101)) << "from the same place";
    run.at.now += std::chrono::milliseconds(300);
  }
  run.move({0, 0.2, 0});
  FeatureFrame blind = run.frame(101);
  blind.images.reset();
  EXPECT_FALSE(run.search(blind));
  const Time due = run.at.now;
  run.at.now -= std::chrono::milliseconds(310);
  EXPECT_FALSE(run.search(101)) << "too soon";
  run.at.now = due;
  EXPECT_TRUE(run.search(101));
}

// The same points with other surfaces, and the same surfaces on other points.
TEST(LoopCloserAppearance, NothingReturnsThatLooksDifferentOrIsElsewhere) {
  for (const bool mixed : {false, true}) {
    SceneRun run(TexturedScene(1));
    run.initialise(1);
    run.search(1);
    run.all_leave();
    const std::vector<test::Surface> before = run.scene.surfaces;
    if (mixed) {
      for (std::size_t k = 0; k < kScenePoints; ++k)
        run.scene.surfaces[k] = before[(5 * k + 3) % kScenePoints];
    } else {
      run.scene.surfaces = TexturedScene(2).surfaces;
    }
    run.move({0, 0.3, 0});
    run.initialise(101);
    EXPECT_FALSE(run.search(101));
    run.move({0, 0.2, 0});
    EXPECT_FALSE(run.search(101)) << mixed;
    EXPECT_TRUE(run.closer.recognised().empty());
  }
}

// It was rejected; observed nine times; without appearance; where another one is chosen.
TEST(LoopCloserAppearance, OnlyCertainPointsMayReturn) {
  SceneRun run(TexturedScene(1));
  run.initialise(1);
  run.initialise(21, 9);
  run.initialise(41);
  const std::size_t kinds = 3 * kScenePoints;
  ASSERT_EQ(run.records.size(), kinds);
  run.search(1);
  run.at.now += std::chrono::seconds(1);
  run.search(21);
  run.records[0].rejected = 5;
  run.all_leave();
  EXPECT_TRUE(std::ranges::equal(run.closer.rejected(), std::array<LandmarkId, 1>{1}));
  for (int i = 0; i < 3 * kScenePoints; ++i) {
    EXPECT_EQ(can_return(run.filter, i), 0 < i && i < kScenePoints) << i;
  }
  // The same points once more have no room beside those.
  run.initialise(61);
  run.at.now += std::chrono::seconds(1);
  run.search(61);
  run.all_leave();
  for (int i = 0; i < kScenePoints; ++i) {
    EXPECT_EQ(can_return(run.filter, 3 * kScenePoints + i), i == 0) << i;
  }
}

// What a run leaves of the scene.
std::shared_ptr<const LandmarkMap> map_of(const TexturedScene& scene) {
  SceneRun run(scene, 9);
  run.initialise(1);
  run.search(1);
  return std::make_shared<LandmarkMap>(
      run.closer.landmark_map(run.filter, run.at.by_imu, std::nullopt));
}

// While the place in the map is not known, landmarks of the run itself return as well. The copy
// that goes on without them does not find them again, and still looks for its place.
TEST(LoopCloserAppearance, ACopyGoesOnWithoutOwnLandmarksWhileAMapIsSearched) {
  SceneRun run(TexturedScene(1), 1, map_of(TexturedScene(2)));
  run.come_back();
  const auto found = run.search(101);
  ASSERT_TRUE(found);
  ASSERT_FALSE(found->of_map);
  std::vector<int> numbers;
  for (const int i : found->accepted) {
    const ProposedMatch& match = found->innovations.matches[static_cast<std::size_t>(i)];
    numbers.push_back(found->candidates[static_cast<std::size_t>(match.landmark)].past->number);
    EXPECT_TRUE(can_return(run.filter, numbers.back()));
  }
  run.closer.leave_out(*found, run.filter);
  for (const int number : numbers) EXPECT_FALSE(can_return(run.filter, number));
  EXPECT_EQ(run.closer.place_counts().proposed, 0);
  EXPECT_EQ(run.closer.place_counts().rejected, 0) << "no place was proposed";
  const auto left_out = matched_ids(*found);
  for (int i = 0; i < 3; ++i) {
    run.move({0, 0.1, 0});
    const auto again = run.search(101);
    if (!again) continue;
    for (const auto& pair : matched_ids(*again)) {
      EXPECT_EQ(std::ranges::count(left_out, pair), 0) << pair.second << " returns";
    }
  }
}

TEST(LoopCloserAppearance, ACopyGoesOnWithoutOwnLandmarksWhereThereIsNoMap) {
  SceneRun run(TexturedScene(1));
  run.come_back();
  const auto found = run.search(101);
  ASSERT_TRUE(found);
  const int match =
      found->innovations.matches[static_cast<std::size_t>(found->accepted.front())].landmark;
  const int number = found->candidates[static_cast<std::size_t>(match)].past->number;
  run.closer.leave_out(*found, run.filter);
  EXPECT_FALSE(can_return(run.filter, number));
  EXPECT_EQ(run.filter.state().landmarks.size(), static_cast<std::size_t>(kScenePoints));
  run.move({});
  EXPECT_FALSE(run.search(101)) << "their matches are to be confirmed anew";
}

// A run in the scene of a map, in a frame of its own.
struct SceneInMap {
  explicit SceneInMap(std::uint64_t seed, int moves = 2)
      : scene(1), run(scene, seed, map_of(scene), test::level_pose(2.5, {10, -3, 2})) {
    run.initialise(101);
    for (int i = 0; i < moves; ++i) {
      frame = run.frame(101);
      found = run.search(frame);
      if (found || i + 1 == moves) break;
      run.move({0, 0.2, 0});
    }
  }

  TexturedScene scene;
  SceneRun run;
  FeatureFrame frame;
  std::optional<LoopReturn> found;
};

TEST(LoopCloserAppearance, FindsThePlaceInAMap) {
  SceneInMap in_map(4);
  SceneRun& run = in_map.run;
  EXPECT_EQ(run.closer.place_counts().proposed, 1);
  ASSERT_TRUE(in_map.found);
  ASSERT_TRUE(in_map.found->of_map);
  EXPECT_FALSE(run.closer.placed());
  const auto matches = matched_ids(*in_map.found);
  // Of the pixels, where the accepted points are thought to be.
  const auto squares = [&](const auto& p_nav) {
    double sum = 0;
    for (const auto& [track, landmark] : matches) {
      const Vector3d p_imu = run.filter.state().world_T_imu.inverse() * p_nav(landmark);
      sum += (in_map.frame.pixels[static_cast<std::size_t>(track - 101)].pixel -
              project(run.scene.camera, run.scene.camera.cam_T_imu * p_imu)->pixel)
                 .squaredNorm();
    }
    return sum;
  };
  const double proposed = squares([&](LandmarkId id) {
    return std::ranges::find(in_map.found->candidates, id, &LoopCandidate::id)->past->p_nav;
  });
  run.closer.close(*in_map.found, run.filter, run.records, run.at);
  ASSERT_TRUE(run.closer.placed());
  const double refined = squares([&](LandmarkId id) {
    return run.filter.state().landmarks[static_cast<std::size_t>(index_of(run.filter, id))].p_world;
  });
  EXPECT_LT(refined, 0.9 * proposed) << "the accepted matches refine the place";
  EXPECT_EQ(run.closer.place_counts().placed, run.at.by_imu);
  const SE3 off = run.closer.placed()->nav_T_map(run.filter) * run.nav_T_scene.inverse();
  EXPECT_LT(so3::log(off.R).norm(), 0.05);
  EXPECT_LT((off * run.nav_T_scene.p - run.nav_T_scene.p).norm(), 0.3);
  // A point of the map in the state is where the scene has the point of its track.
  for (const auto& [track, landmark] : matches) {
    ASSERT_GE(landmark, kFirstMapId);
    const Landmark& l =
        run.filter.state().landmarks[static_cast<std::size_t>(index_of(run.filter, landmark))];
    const Vector3d truth =
        run.nav_T_scene * run.scene.points[static_cast<std::size_t>(track - 101)];
    EXPECT_LT((l.p_world - truth).norm(), 0.5);
  }
  run.observe(run.closer.renamed(in_map.frame));
  const LandmarkMap map = run.closer.landmark_map(run.filter, run.at.by_imu, std::nullopt);
  EXPECT_EQ(map.sessions.size(), 2u);
}

TEST(LoopCloserAppearance, ACopyGivesTheProposedPlaceUp) {
  SceneInMap in_map(4);
  SceneRun& run = in_map.run;
  ASSERT_TRUE(in_map.found && in_map.found->of_map);
  run.closer.leave_out(*in_map.found, run.filter);
  EXPECT_EQ(run.closer.place_counts().rejected, 1);
  EXPECT_FALSE(run.closer.placed());
  EXPECT_EQ(run.filter.past().states(), 0);
  run.move({0, 0.1, 0});
  EXPECT_FALSE(run.search(101)) << "another one is proposed and waits for its confirmation";
  EXPECT_EQ(run.closer.place_counts().proposed, 2);
}

TEST(LoopCloserAppearance, StartsInTheFrameOfAMap) {
  const auto map = map_of(TexturedScene(1));
  SceneRun run(TexturedScene(1), 1, map);
  run.closer.start_in_map(run.filter, from_seconds(4));
  ASSERT_TRUE(run.closer.placed());
  EXPECT_EQ(run.closer.place_counts().placed, from_seconds(4));
  EXPECT_LT(test::distance(run.closer.placed()->nav_T_map(run.filter), SE3{}), 1e-12);
  const int frame = run.closer.placed()->number();
  for (int i = 0; i < static_cast<int>(map->points.size()); ++i) {
    EXPECT_EQ(run.filter.past().landmark(frame + 1 + i).id, kFirstMapId + i);
  }
  // Its points return as past landmarks do.
  run.initialise(101);
  EXPECT_FALSE(run.search(101));
  run.move({0, 0.2, 0});
  auto found = run.search(101);
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->of_map);
  for (const auto& [track, landmark] : matched_ids(*found)) {
    const Vector3d& p_map = map->points[static_cast<std::size_t>(landmark - kFirstMapId)].p_map;
    EXPECT_LT((p_map - run.scene.points[static_cast<std::size_t>(track - 101)]).norm(), 0.2);
  }
}

}  // namespace
}  // namespace chasles
