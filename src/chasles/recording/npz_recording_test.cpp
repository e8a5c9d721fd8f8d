#include <chasles/codec/npz_archive.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/testing.hpp>

namespace chasles {
namespace {

using test::Drive;
using test::drive;
using test::expect_parts;
using test::feature_at;
using test::input_error;
using test::NpyField;
using test::NpzFields;

class NpzRecording : public ::testing::Test {
 protected:
  static constexpr std::size_t kTracks = 200;

  Recording read(const ReaderSettings& settings = {}) {
    const auto file = test::scratch() / "drive.npz";
    write_npz(file, fields);
    return read_npz_recording(file, settings);
  }
  std::string error() {
    return input_error([this] { read(); });
  }
  NpyField& features() { return fields["features"]; }
  double& feature(std::size_t pixel, std::size_t track, std::size_t frame) {
    return features().values[feature_at(features(), pixel, track, frame)];
  }
  void set(std::size_t track, std::size_t frame, const Eigen::Vector4d& pixels) {
    for (std::size_t i = 0; i < 4; ++i) feature(i, track, frame) = pixels[static_cast<int>(i)];
  }
  // An archive of three tracks and six frames without observations.
  void clear() {
    fields = test::npz_fields(drive(Drive{.frames = 6, .tracks = 3}), 3);
    for (double& value : features().values) value = -1;
  }

  Recording truth = drive(Drive{.tracks = kTracks});
  NpzFields fields = test::npz_fields(truth, kTracks);
};

void expect_same_frames(const std::vector<FeatureFrame>& a, const std::vector<FeatureFrame>& b,
                        double tolerance) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    ASSERT_EQ(a[k].observations.size(), b[k].observations.size()) << "frame " << k;
    for (std::size_t i = 0; i < a[k].observations.size(); ++i) {
      EXPECT_EQ(a[k].observations[i].landmark, b[k].observations[i].landmark);
      EXPECT_LE((a[k].observations[i].pixels - b[k].observations[i].pixels).norm(), tolerance);
    }
  }
}

TEST_F(NpzRecording, HoldsWhatWasWritten) {
  const Recording r = read();
  EXPECT_EQ(r.name, "drive");
  ASSERT_EQ(r.velocities.size(), truth.velocities.size());
  EXPECT_EQ(r.velocities[3].linear_imu, truth.velocities[3].linear_imu);
  EXPECT_EQ(r.velocities[3].angular_imu, truth.velocities[3].angular_imu);
  EXPECT_EQ(r.velocities[0].time, from_seconds(1e9));
  EXPECT_EQ(r.frames[0].time, r.velocities[0].time);
  EXPECT_EQ(r.rig.fx, truth.rig.fx);
  EXPECT_EQ(r.rig.cy, truth.rig.cy);
  EXPECT_EQ(r.rig.baseline, truth.rig.baseline);
  expect_same_frames(r.frames, truth.frames, 0);
}

TEST_F(NpzRecording, EveryLayoutOfTheArraysMeansTheSame) {
  for (auto& [name, field] : fields) field.fortran_order = true;
  expect_same_frames(read().frames, truth.frames, 0);
  for (auto& [name, field] : fields) field.version = 2;
  expect_same_frames(read().frames, truth.frames, 0);
  features().descr = "<f4";
  expect_same_frames(read().frames, truth.frames, 2e-4);
  features().fortran_order = false;
  expect_same_frames(read().frames, truth.frames, 2e-4);
}

TEST_F(NpzRecording, TheBaselineMayBeAnyShapeOfOneNumber) {
  for (const std::vector<std::size_t>& shape : {std::vector<std::size_t>{}, {1}, {1, 1}}) {
    fields["b"].shape = shape;
    EXPECT_EQ(read().rig.baseline, truth.rig.baseline);
  }
}

TEST_F(NpzRecording, TheMalformedExtrinsicIsCorrectedAndReported) {
  const Recording r = read();
  EXPECT_LT((r.rig.cam0_T_imu.p - truth.rig.cam0_T_imu.p).norm(), 1e-12);
  ASSERT_EQ(r.remarks.size(), 1u);
  expect_parts(r.remarks[0], {"cam_T_imu is taken as [C | -C rho], not as [C | rho]", "sigmas"});
}

TEST_F(NpzRecording, TheExtrinsicIsTakenAsRecordedWhereTheSettingsSaySo) {
  const Recording r = read({.extrinsics = ArchiveExtrinsics::kRecorded});
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(r.rig.cam0_T_imu.p[i],
              fields["cam_T_imu"].values[4 * static_cast<std::size_t>(i) + 3]);
  }
  EXPECT_GT((r.rig.cam0_T_imu.p - truth.rig.cam0_T_imu.p).norm(), 0.1);
  expect_parts(r.remarks.at(0), {"cam_T_imu is taken as recorded"});
}

TEST_F(NpzRecording, AWellFormedExtrinsicIsLeftAlone) {
  for (std::size_t i = 0; i < 3; ++i) {
    fields["cam_T_imu"].values[4 * i + 3] = truth.rig.cam0_T_imu.p[static_cast<int>(i)];
  }
  const Recording r = read();
  EXPECT_LT((r.rig.cam0_T_imu.p - truth.rig.cam0_T_imu.p).norm(), 1e-12);
  ASSERT_EQ(r.remarks.size(), 1u);
  expect_parts(r.remarks[0], {"cam_T_imu is taken as [C | rho], not as [C | -C rho]"});
}

TEST_F(NpzRecording, WhereADriveCannotDecideTheKnownReadingIsTakenAndReported) {
  truth = drive(Drive{.yaw_rate = 0, .tracks = kTracks});
  fields = test::npz_fields(truth, kTracks);
  const Recording r = read();
  EXPECT_LT((r.rig.cam0_T_imu.p - truth.rig.cam0_T_imu.p).norm(), 1e-12);
  expect_parts(r.remarks.at(0), {"these data do not decide"});
}

TEST_F(NpzRecording, TheNamesOfLaterArchivesAreKnown) {
  fields["angular_velocity"] = fields["rotational_velocity"];
  fields.erase("rotational_velocity");
  const SE3 imu_T_cam0 = truth.rig.cam0_T_imu.inverse();
  NpyField& M = fields["imu_T_cam"] = fields["cam_T_imu"];
  fields.erase("cam_T_imu");
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      M.values[4 * i + j] = imu_T_cam0.R(static_cast<int>(i), static_cast<int>(j));
    }
    M.values[4 * i + 3] = imu_T_cam0.p[static_cast<int>(i)];
  }
  const Recording r = read();
  EXPECT_LT((r.rig.cam0_T_imu.p - truth.rig.cam0_T_imu.p).norm(), 1e-12);
  EXPECT_LT((r.rig.cam0_T_imu.R - truth.rig.cam0_T_imu.R).norm(), 1e-12);
  EXPECT_TRUE(r.remarks.empty());
}

TEST_F(NpzRecording, FramesWithoutObservationsStayAsEmptyFrames) {
  clear();
  set(1, 3, {400, 100, 380, 100});
  const Recording r = read();
  ASSERT_EQ(r.frames.size(), 6u);
  EXPECT_TRUE(r.frames[0].observations.empty());
  EXPECT_EQ(r.frames[3].observations.size(), 1u);
  expect_parts(r.remarks.at(0), {"5 of 6 frames have no observation"});
}

TEST_F(NpzRecording, DisparitiesThatAreNotPositiveAreLeftOutAndCounted) {
  clear();
  set(0, 1, {400, 100, 400, 100});
  set(1, 1, {400, 100, 590, 100});
  set(2, 1, {400, 100, 399, 100});
  const Recording r = read();
  ASSERT_EQ(r.frames[1].observations.size(), 1u);
  EXPECT_EQ(r.frames[1].observations[0].landmark, 2);
  expect_parts(r.remarks.at(0), {"2 of 3 observations have a disparity that is not positive"});
}

TEST_F(NpzRecording, ARepeatedObservationEndsItsLandmarkAndANewOneBegins) {
  clear();
  for (std::size_t k = 0; k < 6; ++k) {
    set(0, k, {400 + 2 * static_cast<double>(k), 100, 380, 100});
    set(2, k, {500 + 2 * static_cast<double>(k), 100, 480, 100});
  }
  set(0, 2, {402, 100, 380, 100});
  set(0, 5, {408, 100, 380, 100});
  const Recording r = read();
  std::vector<LandmarkId> seen;
  for (const FeatureFrame& frame : r.frames) seen.push_back(frame.observations[0].landmark);
  EXPECT_EQ(seen, (std::vector<LandmarkId>{0, 0, 2, 2, 2, 2}));
  EXPECT_EQ(r.frames[2].observations.size(), 1u);
  EXPECT_EQ(r.frames[3].observations[1].landmark, 3) << "track 0, segment 1, of three tracks";
  EXPECT_EQ(r.frames[4].observations[1].landmark, 3);
  EXPECT_EQ(r.frames[5].observations.size(), 1u);
  expect_parts(r.remarks.at(0), {"2 observations in 2 frames repeat"});
  const Recording kept = read({.stale_pixels = StalePixels::kKeep});
  for (const FeatureFrame& frame : kept.frames) {
    ASSERT_EQ(frame.observations.size(), 2u);
    EXPECT_EQ(frame.observations[0].landmark, 0);
  }
  EXPECT_EQ(kept.frames[2].observations[0].pixels, Eigen::Vector4d(402, 100, 380, 100));
}

TEST_F(NpzRecording, ACameraAtStandstillIsNoRepetition) {
  clear();
  for (std::size_t k = 0; k < 6; ++k) set(0, k, {400, 100, 380, 100});
  const Recording r = read();
  for (const FeatureFrame& frame : r.frames) {
    ASSERT_EQ(frame.observations.size(), 1u);
    EXPECT_EQ(frame.observations[0].landmark, 0);
  }
}

TEST_F(NpzRecording, AnObservationWithHalfItsNumbersIsLeftOutAndCounted) {
  clear();
  set(0, 1, {400, 100, -1, -1});
  EXPECT_TRUE(read().frames[1].observations.empty());
  expect_parts(read().remarks.at(0), {"1 observations have some of their four numbers missing"});
  features().fortran_order = true;
  expect_parts(read().remarks.at(0), {"1 observations have some of their four numbers missing"});
}

TEST_F(NpzRecording, AMissingFieldIsNamedWithTheOneMostLikeIt) {
  fields["linear_velocities"] = fields["linear_velocity"];
  fields.erase("linear_velocity");
  expect_parts(error(), {"drive.npz: field 'linear_velocity': is missing", "'time_stamps'",
                         "did you mean 'linear_velocities'?"});
}

TEST_F(NpzRecording, AWrongShapeIsNamedWithTheExpectedOne) {
  const std::size_t T = truth.frames.size();
  fields["linear_velocity"] = {.shape = {3, T - 1}, .values = std::vector<double>(3 * (T - 1))};
  expect_parts(error(), {"field 'linear_velocity': has shape (3, 59), expected (3, 60)"});
  fields = test::npz_fields(truth, kTracks);
  features().shape = {4, T, kTracks};
  expect_parts(error(), {"field 'features': has shape (4, 60, 200), expected (4, M, 60)"});
  fields = test::npz_fields(truth, kTracks);
  fields["b"] = {.shape = {2}, .values = {1, 2}};
  expect_parts(error(), {"field 'b': has shape (2), expected a single number"});
}

TEST_F(NpzRecording, NumbersThatAreNotFiniteAreNamedWithTheirIndex) {
  fields["linear_velocity"].values[2 * truth.frames.size() + 17] = NAN;
  expect_parts(error(), {"field 'linear_velocity': value nan at index [2, 17]"});
  fields = test::npz_fields(truth, kTracks);
  fields["linear_velocity"].fortran_order = true;
  fields["linear_velocity"].values[2 * truth.frames.size() + 17] = INFINITY;
  expect_parts(error(), {"field 'linear_velocity': value inf at index [2, 17]"});
  clear();
  for (const bool fortran_order : {false, true}) {
    features().fortran_order = fortran_order;
    set(1, 4, {400, 100, NAN, 100});
    expect_parts(error(), {"field 'features': value nan at index [2, 1, 4]"});
    set(1, 4, {INFINITY, 100, 380, 100});
    expect_parts(error(), {"field 'features': value inf at index [0, 1, 4]"});
  }
}

TEST_F(NpzRecording, TimesThatDoNotRiseAreNamedWithBothValues) {
  fields["time_stamps"].values[9] = fields["time_stamps"].values[8];
  expect_parts(error(),
               {"field 'time_stamps': index [0, 9]", "1000000000.799999", "rise strictly"});
}

TEST_F(NpzRecording, TimesBeyondNanosecondsAreRejected) {
  fields["time_stamps"].values[0] = 1e300;
  expect_parts(error(), {"field 'time_stamps': value 1e+300 at index [0, 0]"});
}

TEST_F(NpzRecording, AnImpossibleCameraIsRejected) {
  fields["K"].values[1] = 0.5;
  expect_parts(error(), {"field 'K'", "0.5", "expected a pinhole matrix"});
  fields = test::npz_fields(truth, kTracks);
  fields["K"].values[0] = -700;
  expect_parts(error(), {"field 'K': focal length fx: is -700, expected a positive number"});
  fields = test::npz_fields(truth, kTracks);
  fields["b"].values[0] = 0;
  expect_parts(error(), {"field 'b': the baseline: is 0, expected a positive number"});
}

TEST_F(NpzRecording, AnImpossibleExtrinsicIsRejected) {
  fields["cam_T_imu"].values[1] = -1.1;
  expect_parts(error(), {"field 'cam_T_imu'", "is not a rotation", "0.21"});
  fields = test::npz_fields(truth, kTracks);
  for (std::size_t j = 0; j < 3; ++j) fields["cam_T_imu"].values[j] *= -1;
  expect_parts(error(), {"field 'cam_T_imu'", "reflection (determinant -1)"});
  fields = test::npz_fields(truth, kTracks);
  fields["cam_T_imu"].values[12] = 3;
  expect_parts(error(), {"field 'cam_T_imu'", "the last row is (3, 0, 0, 1)"});
}

TEST_F(NpzRecording, AFieldOfObjectsIsRejected) {
  fields["K"].descr = "|O";
  expect_parts(error(), {"field 'K': has dtype '|O'"});
}

TEST(NpzArchive, AMissingFileAForeignFileAndAnEmptyOneAreRejected) {
  const auto folder = test::scratch();
  expect_parts(input_error([&] { read_npz_recording(folder / "none.npz"); }),
               {"none.npz: no such file"});
  test::spill(folder / "text.npz", "not an archive");
  expect_parts(input_error([&] { read_npz_recording(folder / "text.npz"); }),
               {"text.npz: cannot be opened as a zip archive"});
  test::spill(folder / "empty.npz", "");
  expect_parts(input_error([&] { read_npz_recording(folder / "empty.npz"); }), {"empty.npz"});
  test::write_zip(folder / "other.npz", {{"readme.txt", "hello"}});
  expect_parts(input_error([&] { read_npz_recording(folder / "other.npz"); }),
               {"field 'time_stamps': is missing; the file holds 'readme.txt'"});
}

// Any truncation or change gives an InputError or a recording, never a crash.
TEST(NpzArchive, NoTruncationAndNoDamageCrashes) {
  const auto folder = test::scratch();
  write_npz(folder / "whole.npz", test::npz_fields(drive(Drive{.frames = 8, .tracks = 10}), 10));
  const std::string whole = test::slurp(folder / "whole.npz");
  const auto read = [&](const std::string& bytes) {
    test::spill(folder / "part.npz", bytes);
    try {
      read_npz_recording(folder / "part.npz");
      return true;
    } catch (const InputError&) {
      return false;
    }
  };
  ASSERT_TRUE(read(whole));
  for (std::size_t size = 0; size < whole.size(); size += 23) {
    EXPECT_FALSE(read(whole.substr(0, size))) << "cut to " << size << " bytes";
  }
  test::Random random(3);
  for (int i = 0; i < 400; ++i) {
    std::string bytes = whole;
    const auto at = static_cast<std::size_t>(random.uniform(0, static_cast<double>(bytes.size())));
    bytes[at] = static_cast<char>(random.uniform(0, 256));
    read(bytes);
  }
}

TEST(NpzArchive, EntriesThatLieAboutTheirSizeAreRejected) {
  const auto folder = test::scratch();
  const std::string claim =
      test::npy_header("{'descr': '<f8', 'fortran_order': False, 'shape': (1, 500000000), }");
  test::write_zip(folder / "claim.npz", {{"time_stamps.npy", claim + std::string(64, 'x')}});
  expect_parts(input_error([&] { read_npz_recording(folder / "claim.npz"); }),
               {"field 'time_stamps': has 192 bytes, expected 4000000128 for its shape"});
  // The size in the archive's directory, changed to 3 GB.
  std::string bytes = test::slurp(folder / "claim.npz");
  const std::size_t directory = bytes.find("PK\x01\x02");
  ASSERT_NE(directory, std::string::npos);
  bytes[directory + 27] = '\x7f';
  test::spill(folder / "claim.npz", bytes);
  const std::string message = input_error([&] { read_npz_recording(folder / "claim.npz"); });
  expect_parts(message, {"field 'time_stamps'"});
}

TEST(NpzArchive, DamagedNumbersAreFoundByTheCheckSum) {
  const auto folder = test::scratch();
  NpzFields fields = test::npz_fields(drive(Drive{.frames = 8, .tracks = 10}), 10);
  write_npz(folder / "whole.npz", fields);
  NpzArchive archive(folder / "whole.npz");
  EXPECT_EQ(archive.read("K").values[0], 700);
  std::string bytes = test::slurp(folder / "whole.npz");
  const std::size_t directory = bytes.find("PK\x01\x02");
  bytes[directory + 16] = static_cast<char>(bytes[directory + 16] ^ 1);  // the first check sum
  test::spill(folder / "damaged.npz", bytes);
  const std::string field = NpzArchive(folder / "damaged.npz").fields().front();
  expect_parts(input_error([&] { NpzArchive(folder / "damaged.npz").read(field); }),
               {"damaged.npz: field '" + field + "'"});
}

}  // namespace
}  // namespace chasles
