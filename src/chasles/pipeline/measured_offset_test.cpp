#include <gtest/gtest.h>

#include <chasles/pipeline/liveliest_part.hpp>
#include <chasles/pipeline/measured_offset.hpp>
#include <chasles/pipeline/run_of_images_testing.hpp>
#include <chasles/slam/inertial_session_testing.hpp>

// Runs over images that are stamped late or early, on a rendered walk.
namespace chasles {
namespace {

using test::error_from;
using test::RunOfImages;

// The same images with other stamps.
class Shifted : public ImageSource {
 public:
  Shifted(std::shared_ptr<const ImageSource> images, Time late)
      : images_(std::move(images)), late_(late) {}
  std::size_t size() const override { return images_->size(); }
  Time time(std::size_t i) const override { return images_->time(i) + late_; }
  ImageFrame read(std::size_t i) const override {
    ImageFrame frame = images_->read(i);
    frame.time += late_;
    return frame;
  }

 private:
  std::shared_ptr<const ImageSource> images_;
  Time late_;
};

class MeasuredOffset : public RunOfImages {
 protected:
  static Recording late(double seconds) {
    Recording recording = walk();
    recording.images = std::make_shared<Shifted>(recording.images, from_seconds(seconds));
    return recording;
  }
  // Decides the settings of a run; returns its remarks.
  static std::string start(InertialRunSettings& settings, const Recording& recording) {
    const TracksEvidence evidence = examine_tracks(recording, settings);
    std::string all;
    for (const std::string& remark : remarks_of(evidence, settings)) all += remark;
    start_from_measured(settings, evidence);
    return all;
  }
};

// The recording says nothing of its shutter.
TEST_F(MeasuredOffset, ARunTakesTheReadoutThatItsImagesShow) {
  InertialScene scene = inertial_scene("walk");
  scene.settings.walk_duration = 20;
  scene.settings.readout_time = 0.03;
  Recording recording = render_inertial(scene);
  recording.cameras.front().shutter = {};
  InertialRunSettings settings;
  const std::string remark = start(settings, recording);
  ASSERT_TRUE(settings.filter.readout_time) << remark;
  EXPECT_NEAR(*settings.filter.readout_time, 0.03, 0.002);
  EXPECT_NEAR(settings.filter.initial_time_offset(), 0, 0.002) << "of the first line";
  EXPECT_NE(remark.find("the shutter rolls: its readout takes "), std::string::npos) << remark;
  EXPECT_NE(remark.find("the run estimates it from there"), std::string::npos) << remark;
  EXPECT_EQ(settings.filter.calibrate_readout, Calibrate::kTrue);

  InertialRunSettings known;
  known.filter.calibrate_readout = Calibrate::kFalse;
  EXPECT_NE(start(known, recording).find("the run takes it as stated"), std::string::npos);
  EXPECT_EQ(known.filter.calibrate_readout, Calibrate::kFalse);
  InertialRunSettings batch;
  batch.estimator = estimator_choice("batch");
  EXPECT_NE(start(batch, recording).find("the run takes it as stated"), std::string::npos);
  EXPECT_FALSE(batch.filter.has_intrinsics());

  InertialRunSettings global;
  global.filter.readout_time = 0;
  EXPECT_EQ(start(global, recording).find("the shutter rolls"), std::string::npos);
  EXPECT_NEAR(global.filter.initial_time_offset(), 0.015, 0.002) << "of the middle line";

  recording.cameras.front().shutter.readout = 0.03;
  InertialRunSettings stated;
  EXPECT_EQ(start(stated, recording), "");
  EXPECT_FALSE(stated.filter.readout_time || stated.filter.has_intrinsics());
}

TEST_F(MeasuredOffset, IsWhereARunStarts) {
  for (const double seconds : {0.095, -0.06}) {
    InertialRunSettings settings;
    const std::string remark = start(settings, late(seconds));
    EXPECT_NEAR(settings.filter.initial_time_offset(), -seconds, 0.002);
    EXPECT_LT(settings.filter.initial_time_offset_sigma, 0.003);
    EXPECT_TRUE(settings.filter.has_time_offset());
    EXPECT_NE(remark.find(seconds > 0 ? "stamped late by 9" : "stamped early by "),
              std::string::npos)
        << remark;
    EXPECT_NE(remark.find("time_offset=0"), std::string::npos);
  }
}

TEST_F(MeasuredOffset, OfIntactStampsIsNone) {
  for (const double seconds : {0.0, 0.005}) {
    InertialRunSettings settings;
    EXPECT_EQ(start(settings, late(seconds)), "");
    EXPECT_EQ(settings.filter.time_offset, 0);
    EXPECT_EQ(settings.filter.initial_time_offset_sigma,
              InertialSlamSettings{}.initial_time_offset_sigma);
    EXPECT_EQ(settings.filter.calibrate_time_offset, Calibrate::kAuto);
  }
}

TEST_F(MeasuredOffset, ThatIsStatedIsNotMeasured) {
  InertialRunSettings settings;
  settings.filter.time_offset = 0;
  EXPECT_EQ(start(settings, late(0.095)), "");
  EXPECT_EQ(settings.filter.time_offset, 0);
}

TEST_F(MeasuredOffset, OfABatchIsHeldFixed) {
  InertialRunSettings settings;
  settings.estimator = estimator_choice("batch");
  EXPECT_NE(start(settings, late(0.095)), "");
  EXPECT_NEAR(settings.filter.initial_time_offset(), -0.095, 0.002);
  EXPECT_FALSE(settings.filter.has_time_offset());
}

TEST_F(MeasuredOffset, MakesARunOfLateImagesAsGoodAsOfIntactOnes) {
  const double intact = error_from(chasles::run(walk(), InertialRunSettings{}).estimates, walk());
  for (const double seconds : {0.095, -0.06}) {
    const RunResult run = chasles::run(late(seconds), InertialRunSettings{});
    EXPECT_GT(run.estimates.size(), 0.8 * static_cast<double>(walk().images->size()));
    EXPECT_LT(error_from(run.estimates, walk()), 2 * intact + 0.01) << seconds;
    ASSERT_TRUE(run.estimates.back().calibration);
    EXPECT_NEAR(*run.estimates.back().calibration->time_offset, -seconds, 0.002);
  }
}

TEST_F(MeasuredOffset, EndsWhereARunIsToEnd) {
  InertialRunSettings settings;
  EXPECT_FALSE(examine_tracks(late(0.095), settings, [] { return true; }).clock);
  EXPECT_TRUE(tracks_of_first_camera(walk(), {}, 5, [] { return true; }).empty());
}

TEST_F(MeasuredOffset, TakesThePartThatTurnsMost) {
  Recording recording = walk();
  for (ImuSample& s : recording.imu) s.angular_rate_imu.setZero();
  const Time first = recording.images->time(0), begin = first + from_seconds(4);
  for (ImuSample& s : recording.imu) {
    if (s.time > begin && s.time < begin + from_seconds(1)) s.angular_rate_imu.setOnes();
  }
  const auto part = liveliest_part(recording, 2);
  EXPECT_LE(part->time(0), begin);
  EXPECT_GE(part->time(part->size() - 1), begin + from_seconds(0.9));
  EXPECT_LE(part->time(part->size() - 1) - part->time(0), from_seconds(2));
  EXPECT_EQ(liveliest_part(recording, 1e4)->size(), recording.images->size());
}

}  // namespace
}  // namespace chasles
