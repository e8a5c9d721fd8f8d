#include <chasles/recording/readers.hpp>
#include <chasles/recording/testing.hpp>

namespace chasles {
namespace {

using test::Drive;
using test::drive;
using test::expect_parts;
using test::input_error;

class RecordingFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = test::scratch() / "drive";
    recording.frames[2].observations.clear();
    recording.frames[7].observations.clear();
    recording.name = "a \"name\": with # signs";
    recording.remarks = {"one, two: 3 %", "ÄÖÜ \\ \"quoted\""};
    recording.rig.cam0_T_imu.R = so3::exp({0.1, -2, 0.3});
    write_folder_recording(recording, folder);
  }
  // Replaces the first occurrence in a file of the folder and returns the reader's error message.
  std::string error(const std::string& file, const std::string& from, const std::string& to) {
    write_folder_recording(recording, folder);
    std::string text = test::slurp(folder / file);
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    test::spill(folder / file, text.replace(at, from.size(), to));
    return input_error([&] { read_folder_recording(folder); });
  }

  Recording recording = drive(Drive{.frames = 12, .tracks = 30, .speed_noise = 0.3});
  std::filesystem::path folder;
};

TEST_F(RecordingFolder, IsReadAgainToTheLastBit) {
  const Recording r = read_folder_recording(folder);
  EXPECT_EQ(r.name, recording.name);
  EXPECT_EQ(r.remarks, recording.remarks);
  EXPECT_EQ(r.rig.fx, recording.rig.fx);
  EXPECT_EQ(r.rig.cam0_T_imu.R, recording.rig.cam0_T_imu.R);
  EXPECT_EQ(r.rig.cam0_T_imu.p, recording.rig.cam0_T_imu.p);
  ASSERT_EQ(r.velocities.size(), recording.velocities.size());
  for (std::size_t k = 0; k < r.velocities.size(); ++k) {
    EXPECT_EQ(r.velocities[k].time, recording.velocities[k].time);
    EXPECT_EQ(r.velocities[k].linear_imu, recording.velocities[k].linear_imu);
    EXPECT_EQ(r.velocities[k].angular_imu, recording.velocities[k].angular_imu);
  }
  ASSERT_EQ(r.frames.size(), recording.frames.size());
  for (std::size_t k = 0; k < r.frames.size(); ++k) {
    EXPECT_EQ(r.frames[k].time, recording.frames[k].time);
    ASSERT_EQ(r.frames[k].observations.size(), recording.frames[k].observations.size());
    for (std::size_t i = 0; i < r.frames[k].observations.size(); ++i) {
      const auto &a = r.frames[k].observations[i], &b = recording.frames[k].observations[i];
      EXPECT_EQ(a.landmark, b.landmark);
      EXPECT_EQ(a.pixels, b.pixels);
    }
  }
  ASSERT_EQ(r.truth.size(), recording.truth.size());
  EXPECT_EQ(r.truth[9].pose.p, recording.truth[9].pose.p);
  EXPECT_LT((r.truth[9].pose.R - recording.truth[9].pose.R).norm(), 1e-14);
  ASSERT_EQ(r.true_landmarks.size(), recording.true_landmarks.size());
  EXPECT_EQ(r.true_landmarks[3].p_world, recording.true_landmarks[3].p_world);
}

TEST_F(RecordingFolder, StatesItsNoiseWhereItIsKnown) {
  EXPECT_FALSE(read_folder_recording(folder).velocity_sigma);
  EXPECT_FALSE(read_folder_recording(folder).pixel_sigma);
  recording.velocity_sigma = BodyVelocitySigma{.linear = {0.1, 0.2, 0.3}, .angular = {1, 2, 3}};
  recording.pixel_sigma = Eigen::Vector4d(0.5, 1.0 / 3, 0.7, 1e-3);
  write_folder_recording(recording, folder);
  const Recording r = read_folder_recording(folder);
  EXPECT_EQ(r.velocity_sigma->linear, recording.velocity_sigma->linear);
  EXPECT_EQ(r.velocity_sigma->angular, recording.velocity_sigma->angular);
  EXPECT_EQ(*r.pixel_sigma, *recording.pixel_sigma);
}

TEST_F(RecordingFolder, StatedNoiseThatIsNoNoiseIsRejectedWithItsLine) {
  recording.velocity_sigma = BodyVelocitySigma{.linear = {0.1, 0.2, 0.3}, .angular = {1, 2, 3}};
  recording.pixel_sigma = Eigen::Vector4d(0.5, 0.5, 0.5, 0.5);
  expect_parts(error("calibration.yaml", "[0.1, 0.2, 0.3]", "[0.1, -0.2, 0.3]"),
               {"calibration.yaml:", "linear_sigma", "-0.2"});
  expect_parts(error("calibration.yaml", "[1, 2, 3]", "[1, 2]"),
               {"calibration.yaml:", "angular_sigma", "3 standard deviations"});
  expect_parts(error("calibration.yaml", "[0.5, 0.5, 0.5, 0.5]", "[0.5, .nan, 0.5, 0.5]"),
               {"calibration.yaml:", "pixel_sigma"});
  expect_parts(error("calibration.yaml", "angular_sigma: [1, 2, 3]\n", ""),
               {"linear_sigma and angular_sigma", "both or neither"});
}

TEST_F(RecordingFolder, IsRecognisedByItsContent) {
  EXPECT_EQ(read_recording(folder).name, recording.name);
}

TEST_F(RecordingFolder, TruthOfAnEarlierRecordingDoesNotStay) {
  recording.truth.clear();
  recording.true_landmarks.clear();
  write_folder_recording(recording, folder);
  const Recording r = read_folder_recording(folder);
  EXPECT_TRUE(r.truth.empty());
  EXPECT_TRUE(r.true_landmarks.empty());
}

TEST_F(RecordingFolder, KeysOfTheCalibrationAreChecked) {
  const std::string file = "calibration.yaml";
  expect_parts(error(file, "baseline:", "baselin:"),
               {"calibration.yaml:10: key 'baselin': is unknown", "did you mean 'baseline'?"});
  expect_parts(error(file, "fx: 700\n", ""), {"calibration.yaml: key 'fx' is missing"});
  expect_parts(error(file, "fx: 700\n", "fx: 700\nfx: 701\n"), {":6: key 'fx': is there twice"});
  expect_parts(error(file, "fx: 700", "fx: wide"), {":5: key 'fx': found 'wide'"});
  expect_parts(error(file, "fx: 700", "fx: .nan"), {":5: key 'fx': found '.nan'"});
  expect_parts(error(file, "fx: 700", "fx: [1, 2]"), {":5: key 'fx': expected a single value"});
  expect_parts(error(file, "baseline: 0.54", "baseline: -0.54"), {"expected a positive number"});
  expect_parts(error(file, "recording-1", "recording-9"), {":2: key 'format': is 'chasles-recor"});
  expect_parts(error(file, "[0, 0, 0, 1]", "[0, 0, 1]"), {":17: key 'cam0_T_imu': expected a row"});
  expect_parts(error(file, "[0, 0, 0, 1]", "[0, 0, 0, 2]"), {"the last row is (0, 0, 0, 2)"});
  expect_parts(error(file, "fx: 700", "fx: [700"), {"calibration.yaml:", "not valid YAML"});
  test::spill(folder / file, "17\n");
  expect_parts(input_error([&] { read_folder_recording(folder); }),
               {"calibration.yaml: expected lines `key: value`"});
}

TEST_F(RecordingFolder, TablesAreChecked) {
  expect_parts(error("velocities.csv", "vx,vy", "vy,vx"),
               {"velocities.csv:1: has the columns time_ns,vy,vx", "expected time_ns,vx,vy"});
  expect_parts(error("velocities.csv", "\n100000000,", "\n0,"),
               {"velocities.csv:3: column 'time_ns': the time 0.000000000", "rise strictly"});
  expect_parts(error("velocities.csv", "\n100000000,", "\n100000000,nan,"),
               {"velocities.csv:3: has 8 values, expected 7"});
  expect_parts(error("velocities.csv", "\n0,", "\n0.5,"),
               {"velocities.csv:2: column 'time_ns': found '0.5', expected an integer"});
  expect_parts(error("frames.csv", "\n200000000,0", "\n200000000,3"),
               {"features.csv: holds 0 observations of the frame at 200000000 ns, expected 3"});
  expect_parts(error("features.csv", "\n100000000,", "\n100000001,"),
               {"features.csv:", "column 'time_ns': 100000001 is no frame of frames.csv"});
  test::spill(folder / "features.csv", "");
  expect_parts(input_error([&] { read_folder_recording(folder); }), {"features.csv: is empty"});
  std::filesystem::remove(folder / "frames.csv");
  expect_parts(input_error([&] { read_folder_recording(folder); }), {"frames.csv: no such file"});
}

TEST_F(RecordingFolder, ALandmarkSeenTwiceInAFrameIsRejected) {
  recording.frames[3].observations.push_back(recording.frames[3].observations.front());
  write_folder_recording(recording, folder);
  expect_parts(input_error([&] { read_folder_recording(folder); }),
               {"features.csv: landmark ", "twice at 300000000 ns"});
}

TEST_F(RecordingFolder, ATruncatedFileIsNoticed) {
  for (const char* file : {"features.csv", "frames.csv", "calibration.yaml"}) {
    write_folder_recording(recording, folder);
    const std::string text = test::slurp(folder / file);
    for (std::size_t cut = 1; cut < 200; cut += 7) {
      test::spill(folder / file, text.substr(0, text.size() - std::min(cut, text.size())));
      try {
        const Recording r = read_folder_recording(folder);
        if (std::string(file) == "calibration.yaml") continue;  // only remarks may be lost
        expect_parts(r.remarks.back(), {file, "may be truncated"});
      } catch (const InputError& error) {
        expect_parts(error.what(), {folder.string()});
      }
    }
  }
}

TEST(ReadRecording, UnknownKindsAreRejectedWithWhatIsKnown) {
  const auto folder = test::scratch();
  expect_parts(input_error([&] { read_recording(folder / "none"); }),
               {"none: no such file or folder", "ECE276A .npz"});
  test::spill(folder / "notes.txt", "of years");
  expect_parts(input_error([&] { read_recording(folder); }), {"holds no calibration.yaml"});
  test::spill(folder / "a.npz", "text");
  expect_parts(input_error([&] { read_recording(folder / "a.npz"); }), {"of no known kind"});
  test::spill(folder / "a.mat", "");
  expect_parts(input_error([&] { read_recording(folder / "a.mat"); }), {"is empty"});
}

TEST(ReadRecording, TheKindIsRecognisedByContentNotByName) {
  const auto file = test::scratch() / "drive.dat";
  write_npz(file, test::npz_fields(drive(Drive{.frames = 6, .tracks = 4}), 4));
  EXPECT_EQ(read_recording(file).frames.size(), 6u);
}

TEST(EventStream, AVelocityComesBeforeAFrameOfTheSameInstant) {
  Recording r;
  for (const int t : {0, 10, 20}) r.velocities.push_back({.time = Time(t)});
  for (const int t : {5, 10, 30}) r.frames.push_back({.time = Time(t), .observations = {}});
  EventStream stream(r);
  std::vector<std::pair<Time::rep, bool>> order;
  while (const auto event = stream.next()) {
    std::visit(
        [&](const auto& e) {
          order.emplace_back(e.time.count(),
                             std::is_same_v<std::decay_t<decltype(e)>, FeatureFrame>);
        },
        *event);
  }
  EXPECT_EQ(order, (std::vector<std::pair<Time::rep, bool>>{
                       {0, false}, {5, true}, {10, false}, {10, true}, {20, false}, {30, true}}));
}

/// Images that are never read.
class NumberedImages : public ImageSource {
 public:
  explicit NumberedImages(std::vector<Time> times) : times_(std::move(times)) {}
  std::size_t size() const override { return times_.size(); }
  Time time(std::size_t i) const override { return times_[i]; }
  ImageFrame read(std::size_t i) const override { return {.time = times_[i], .images = {}}; }

 private:
  std::vector<Time> times_;
};

TEST(EventStream, TheSamplesAroundAnImageComeBeforeIt) {
  Recording r;
  for (const int t : {0, 10, 20}) r.imu.push_back({.time = Time(t)});
  r.images = std::make_shared<NumberedImages>(std::vector<Time>{Time(5), Time(20)});
  EventStream stream(r);
  std::vector<std::pair<Time::rep, bool>> order;
  std::vector<std::size_t> indices;
  while (const auto event = stream.next()) {
    const auto* due = std::get_if<ImagesDue>(&*event);
    if (due) indices.push_back(due->index);
    std::visit([&](const auto& e) { order.emplace_back(e.time.count(), due != nullptr); }, *event);
  }
  EXPECT_EQ(order, (std::vector<std::pair<Time::rep, bool>>{
                       {0, false}, {10, false}, {5, true}, {20, false}, {20, true}}));
  EXPECT_EQ(indices, (std::vector<std::size_t>{0, 1}));
}

}  // namespace
}  // namespace chasles
