#include <numbers>

#include <gtest/gtest.h>

#include <chasles/check/camera_fit.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/pipeline/liveliest_part.hpp>
#include <chasles/pipeline/measured_offset.hpp>
#include <chasles/pipeline/run_of_images_testing.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/testing.hpp>
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

// In a room the gyroscope fit of a flight begins 12 to 60 deg off (refit_from_lens()).
TEST_F(MeasuredOffset, OfAFlightInARoomIsThatOfItsRightRotation) {
  const auto kitti = test::recordings();
  if (!kitti) GTEST_SKIP() << "skipped: no recordings";
  InertialScene scene = inertial_scene("trajectory");
  scene.path = read_recording(kitti->parent_path() / "euroc/imu_gt/V1_02_medium_imu.csv.gz").truth;
  scene.settings.seed = 3;
  scene.settings.frame_rate = 20;
  for (const double readout : {0.0, 0.02}) {
    scene.settings.readout_time = readout;
    Recording recording = render_inertial(scene);
    recording.cameras.front().shutter = {};
    const auto tracks = tracks_of_first_camera(recording, {}, kExaminedSeconds);
    const auto fit = fit_camera(tracks, recording.cameras, 0, gyroscope_rates(recording.imu));
    ASSERT_TRUE(fit && fit->gyroscope && fit->lens);
    EXPECT_FALSE(fit->mistake) << fit->mistake->what;
    const Eigen::Matrix3d& stated = recording.cameras.front().cam_T_imu.R;
    EXPECT_LT(so3::log(stated.transpose() * fit->gyroscope->cam_R_imu).norm(), 0.03);
    EXPECT_NEAR(fit->lens->readout.value, readout, 0.002);
    EXPECT_NEAR(fit->offset().value, readout / 2, 0.001);
  }
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

// Samples of a mirrored gyroscope, and in other axes than the extrinsics state.
TEST_F(MeasuredOffset, ARunTakesTheAxesOfItsSamples) {
  const RunResult intact = chasles::run(walk(), InertialRunSettings{});
  const Eigen::Matrix3d turn = so3::exp({0, 0, std::numbers::pi / 2}).array().round();
  struct Case {
    Eigen::Matrix3d rates, forces;
    const char* remark;
  };
  for (const Case& c :
       {Case{Eigen::Vector3d(1, -1, 1).asDiagonal(), Eigen::Matrix3d::Identity(),
             "the gyroscope's y has the wrong sign"},
        Case{turn, turn,
             "the IMU's samples have other axes than the extrinsics state: y, -x, z"}}) {
    Recording recording = walk();
    for (ImuSample& s : recording.imu) {
      s.angular_rate_imu = c.rates * s.angular_rate_imu;
      s.specific_force_imu = c.forces * s.specific_force_imu;
    }
    InertialRunSettings settings;
    const std::string remark = start(settings, recording);
    EXPECT_NE(remark.find(c.remark), std::string::npos) << remark;
    const RunResult run = chasles::run(recording, InertialRunSettings{});
    ASSERT_EQ(run.estimates.size(), intact.estimates.size());
    EXPECT_NEAR(error_from(run.estimates, walk()), error_from(intact.estimates, walk()), 1e-3);
    const RunResult recorded =
        chasles::run(recording, InertialRunSettings{}, {.as_recorded = true});
    EXPECT_GT(error_from(recorded.estimates, walk()), 0.1);
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
