#include <algorithm>
#include <map>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/lie/trajectory.hpp>
#include <chasles/pipeline/recording_sensors.hpp>
#include <chasles/pipeline/run_of_images_testing.hpp>
#include <chasles/slam/inertial_session_testing.hpp>

// Runs from images, on a rendered walk.
namespace chasles {
namespace {

using test::error_from;
using test::RunOfImages;

// Counts the outcomes of observations that are in their frame, and of others.
class Outcomes : public RunObserver {
 public:
  void on_outcomes(const FeatureFrame& frame, std::span<const PixelOutcome> outcomes) override {
    for (const PixelOutcome& one : outcomes) {
      const bool found = std::ranges::any_of(frame.pixels, [&](const PixelObservation& o) {
        return o.landmark == one.observation.landmark && o.camera == one.observation.camera &&
               o.pixel == one.observation.pixel;
      });
      ++(found ? known : unknown);
    }
  }
  int known = 0, unknown = 0;
};

TEST_F(RunOfImages, RecognisesNothingWithoutImagesOrInAWindow) {
  InertialRunSettings settings;
  settings.filter.recognise = Recognise::kAppearance;
  Recording tracks = walk();
  tracks.images.reset();
  EXPECT_THROW(make_estimator(settings, tracks), UsageError);
  EXPECT_NO_THROW(make_estimator(settings, walk()));
  settings.estimator = estimator_choice("window:5");
  EXPECT_THROW(make_estimator(settings, walk()), UsageError);
}

TEST_F(RunOfImages, IsTheSameOnAnyNumberOfThreads) {
  const RunResult one = chasles::run(walk(), InertialRunSettings{}, {.threads = 1});
  const RunResult three = chasles::run(walk(), InertialRunSettings{}, {.threads = 3});
  ASSERT_EQ(one.estimates.size(), three.estimates.size());
  for (std::size_t i = 0; i < one.estimates.size(); ++i) {
    EXPECT_EQ(one.estimates[i].world_T_imu.p, three.estimates[i].world_T_imu.p) << i;
    EXPECT_EQ(one.estimates[i].covariance, three.estimates[i].covariance) << i;
  }
  EXPECT_EQ(one.report.frontend.frames, static_cast<int>(walk().images->size()));
  EXPECT_LT(error_from(one.estimates, walk()), 0.1);
}

// Twice round a block of corridors.
TEST_F(RunOfImages, ClosesLoopsByAppearance) {
  InertialScene scene = walk_scene();
  scene.settings.sections = 8;
  const Recording twice = render_inertial(scene);
  struct Result {
    std::vector<PastPose> path;
    std::vector<Closure> closures;
    std::vector<Time> recognised;
    std::map<LandmarkId, LandmarkId> known_as;
  };
  const auto run_with = [&](Recognise recognise, int threads) {
    InertialRunSettings settings;
    settings.filter.recognise = recognise;
    const auto estimator = make_estimator(settings, twice);
    Outcomes observer;
    const RunReport report = run(twice, *estimator, {}, {.threads = threads}, observer);
    EXPECT_GT(observer.known, 1000);
    EXPECT_EQ(observer.unknown, 0) << "an outcome of no observation of the frame";
    return Result{.path = estimator->whole_map().poses,
                  .closures = report.estimator.closures,
                  .recognised = report.estimator.recognised,
                  .known_as = report.estimator.known_as};
  };
  const auto error_of = [&](const Result& result) {
    Trajectory path;
    for (const PastPose& pose : result.path) path.push_back({pose.time, pose.map_T_imu});
    return error_from(path, twice.truth);
  };
  const Result open = run_with(Recognise::kNone, 3), closed = run_with(Recognise::kAppearance, 3);
  EXPECT_TRUE(open.closures.empty());
  EXPECT_TRUE(open.recognised.empty());
  EXPECT_TRUE(open.known_as.empty());
  ASSERT_FALSE(closed.closures.empty());
  EXPECT_FALSE(closed.known_as.empty());
  for (const auto& [track, landmark] : closed.known_as) EXPECT_LT(landmark, track);
  for (const Closure& closure : closed.closures) {
    EXPECT_GT(to_seconds(closure.time), 32) << "in the first round nothing returns";
    EXPECT_LT(closure.moved, 0.3);
    EXPECT_EQ(std::ranges::count(closed.recognised, closure.time), 1);
  }
  EXPECT_GT(closed.recognised.size(), 2 * closed.closures.size())
      << "most would determine too little";
  EXPECT_LT(error_of(closed), error_of(open) / 2);

  const Result again = run_with(Recognise::kAppearance, 1);
  ASSERT_EQ(again.path.size(), closed.path.size());
  EXPECT_EQ(again.path.back().map_T_imu.p, closed.path.back().map_T_imu.p);
  EXPECT_EQ(again.path.front().covariance, closed.path.front().covariance);
}

TEST_F(RunOfImages, InRealTimeCountsWhatCameAndReportsTheLatency) {
  Images observer;
  const auto estimator = make_estimator(InertialRunSettings{}, walk());
  const RunReport report = run(walk(), *estimator, {}, {.realtime = 4}, observer);
  EXPECT_EQ(report.played.came, walk().images->size());
  EXPECT_EQ(report.played.came, report.played.taken + report.played.dropped);
  EXPECT_GT(observer.latencies, 10);
  EXPECT_GT(observer.frontend_seconds, 0);
}

TEST_F(RunOfImages, AnUnreadableImageIsCountedAndMissing) {
  class Torn : public ImageSource {
   public:
    explicit Torn(std::shared_ptr<const ImageSource> of) : of_(std::move(of)) {}
    std::size_t size() const override { return of_->size(); }
    Time time(std::size_t i) const override { return of_->time(i); }
    ImageFrame read(std::size_t i) const override {
      if (i % 10 == 5) throw InputError("torn");
      return of_->read(i);
    }

   private:
    std::shared_ptr<const ImageSource> of_;
  };
  Recording torn = walk();
  torn.images = std::make_shared<Torn>(walk().images);
  Images observer;
  const auto estimator = make_estimator(InertialRunSettings{}, torn);
  const RunReport report = run(torn, *estimator, {}, {}, observer);
  const int count = (static_cast<int>(torn.images->size()) + 4) / 10;
  EXPECT_EQ(report.frontend.unreadable, count);
  EXPECT_EQ(observer.unreadable, count);
  EXPECT_EQ(observer.images, static_cast<int>(torn.images->size()) - count);
}

TEST_F(RunOfImages, WithTheSecondCameraUnreadableTheFirstContinues) {
  class TornSecond : public ImageSource {
   public:
    explicit TornSecond(std::shared_ptr<const ImageSource> of) : of_(std::move(of)) {}
    std::size_t size() const override { return of_->size(); }
    Time time(std::size_t i) const override { return of_->time(i); }
    ImageFrame read(std::size_t i) const override { return of_->read(i); }
    ImageFrame read_undamaged(std::size_t i, std::size_t, const OnDamage& damaged) const override {
      ImageFrame frame = of_->read(i);
      frame.images.push_back(
          read_or_empty([]() -> GrayImage { throw InputError("torn"); }, damaged));
      return frame;
    }

   private:
    std::shared_ptr<const ImageSource> of_;
  };
  Recording torn = walk();
  torn.cameras.push_back(torn.cameras[0]);
  torn.cameras[1].cam_T_imu.p.x() -= 0.1;
  torn.images = std::make_shared<TornSecond>(walk().images);
  Images observer;
  const auto estimator = make_estimator(InertialRunSettings{}, torn);
  const RunReport report = run(torn, *estimator, {}, {}, observer);
  const int all = static_cast<int>(torn.images->size());
  EXPECT_EQ(report.frontend.unreadable, all);
  EXPECT_EQ(observer.unreadable, all);
  EXPECT_EQ(observer.images, all);
  EXPECT_GT(report.frontend.tracked, 0);
}

TEST_F(RunOfImages, EndsSoonIfNoImageCanBeRead) {
  class Hopeless : public ImageSource {
   public:
    Hopeless(std::shared_ptr<const ImageSource> of, std::size_t first_good)
        : of_(std::move(of)), first_good_(first_good) {}
    std::size_t size() const override { return of_->size(); }
    Time time(std::size_t i) const override { return of_->time(i); }
    ImageFrame read(std::size_t i) const override {
      if (i < first_good_) throw InputError("torn " + std::to_string(i));
      return of_->read(i);
    }

   private:
    std::shared_ptr<const ImageSource> of_;
    std::size_t first_good_;
  };
  Recording torn = walk();
  for (const int threads : {1, 2, 3}) {
    Images observer;
    const auto estimator = make_estimator(InertialRunSettings{}, torn);
    torn.images = std::make_shared<Hopeless>(walk().images, 25);
    try {
      run(torn, *estimator, {}, {.threads = threads}, observer);
      FAIL() << "expected an InputError";
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()), "none of the first 20 of " +
                                               std::to_string(torn.images->size()) +
                                               " frames of images can be read; the first: torn 0");
    }
    EXPECT_EQ(observer.unreadable, 19);
  }
  // One frame less, and the run goes on; whether it finds a start is not the feed's matter.
  torn.images = std::make_shared<Hopeless>(walk().images, 19);
  Images observer;
  const auto estimator = make_estimator(InertialRunSettings{}, torn);
  try {
    run(torn, *estimator, {}, {}, observer);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kNotInitialised) << error.what();
  }
  EXPECT_EQ(observer.unreadable, 19);
  EXPECT_EQ(observer.images, static_cast<int>(torn.images->size()) - 19);
}

TEST_F(RunOfImages, APartOfTheTracksIsFollowed) {
  const RunResult all = chasles::run(walk(), InertialRunSettings{});
  const RunResult half = chasles::run(walk(), InertialRunSettings{}, {.tracks = {.part = 0.5}});
  const auto observations = [](const RunResult& run) {
    double sum = 0;
    for (const Estimate& e : run.estimates) sum += e.observations;
    return sum / static_cast<double>(run.estimates.size());
  };
  EXPECT_LT(observations(half), 0.8 * observations(all));
  EXPECT_GT(observations(half), 0.2 * observations(all));
}

}  // namespace
}  // namespace chasles
