#include <cmath>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <map>
#include <spawn.h>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/recording/readers.hpp>
#include <chasles/run_folder/run.hpp>
#include <chasles/velocity/velocity_settings.hpp>

#include "cli_test.hpp"

// Results of `chasles run`, `evaluate` and `report`.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

Json json_of(const Outcome& outcome) {
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  return Json::parse(outcome.out);
}

std::map<std::string, std::string> files_of_run(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    files[entry.path().filename().string()] = slurp(entry.path());
  }
  return files;
}

TEST(Run, WritesTheSameBytesTwiceButForTheTiming) {
  const Scratch folder;
  simulate(folder);
  ASSERT_EQ(chasles(folder, "run rec -o one").code, 0);
  ASSERT_EQ(chasles(folder, "run ./rec -o elsewhere/two").code, 0);
  auto one = files_of_run(folder / "one"), two = files_of_run(folder / "elsewhere/two");
  for (const char* file : {"timing.csv", "timing.json"}) {
    EXPECT_EQ(one.erase(file), 1u);
    EXPECT_EQ(two.erase(file), 1u);
  }
  EXPECT_EQ(one.size(), 9u);
  EXPECT_TRUE(one == two);
}

TEST(Run, SummaryHasEveryNameOfTheDesign) {
  const Scratch folder;
  simulate(folder);
  const Json printed = json_of(chasles(folder, "run rec -o out --json --quiet"));
  for (const char* name : {"ate_m", "ate_posyaw_m", "ate_first_pose_m", "attitude_deg",
                           "nees_position", "nees_attitude", "nees_pose", "nis_per_dof", "frames",
                           "landmarks", "seconds_wall", "seconds_cpu", "realtime_factor"}) {
    EXPECT_TRUE(printed.at(name).is_number()) << name;
  }
  EXPECT_TRUE(printed.at("health").is_string());
  Json stored = Json::parse(slurp(folder / "out/summary.json"));
  stored.update(Json::parse(slurp(folder / "out/timing.json")));
  EXPECT_EQ(stored, printed);
  const VelocitySlamSettings settings;
  for_each_setting(settings,
                   [&](const char* name, const auto&, const char*, const char*, const Limits&) {
                     EXPECT_TRUE(printed.at("settings").contains(name)) << name;
                   });
}

TEST(Run, WithoutATruthTheFiguresThatNeedOneAreNull) {
  const Scratch folder;
  simulate(folder);
  const Json with = json_of(chasles(folder, "run rec --json --quiet"));
  std::filesystem::copy(folder / "rec/truth.tum", folder / "truth.tum");
  std::filesystem::remove(folder / "rec/truth.tum");
  std::filesystem::remove(folder / "rec/landmarks_truth.csv");
  const Json without = json_of(chasles(folder, "run rec --json --quiet"));
  EXPECT_TRUE(without.at("ate_m").is_null());
  EXPECT_TRUE(without.at("nees_pose").is_null());
  EXPECT_EQ(without.at("nis_per_dof"), with.at("nis_per_dof"));
  const Json given = json_of(chasles(folder, "run rec --truth truth.tum --json --quiet"));
  EXPECT_EQ(given.at("ate_m"), with.at("ate_m"));
  expect_error(chasles(folder, "run rec --quiet --ate-below 1"), 1,
               "--ate-below: street has no true");
}

TEST(Run, WithoutAnOutputFolderLeavesNothingBehind) {
  const Scratch folder;
  simulate(folder);
  const Outcome outcome = chasles(folder, "run rec --quiet");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.err, "");
  expect_part(outcome.out, "ATE, SE(3)-aligned");
  EXPECT_EQ(files_of_run(folder / "rec").size(), 6u);
}

TEST(Run, AMissedThresholdEndsWithFiveAndAMetOneWithZero) {
  const Scratch folder;
  simulate(folder);
  EXPECT_EQ(chasles(folder, "run rec --quiet --ate-below 1000 --nees-below 1e9").code, 0);
  const Outcome missed = chasles(folder, "run rec --quiet -o out --ate-below 1e-9");
  EXPECT_EQ(missed.code, 5);
  expect_part(missed.err, "chasles: error: missed: ate_m is ");
  EXPECT_TRUE(std::filesystem::exists(folder / "out/summary.json"));
  // The path has no piece of 100 m, so the figure has no value and misses its threshold.
  const Outcome none = chasles(folder, "run rec --quiet --stop 3 --rpe-below 50");
  EXPECT_EQ(none.code, 5);
  expect_part(none.err, "rpe_100m_percent has no value here");
  EXPECT_EQ(chasles(folder, "evaluate out --ate-below 1e-9").code, 5);
}

TEST(Run, CoverageIsAFigureAndAThreshold) {
  const Scratch folder;
  simulate(folder);
  const Json whole = json_of(chasles(folder, "run rec --json --quiet --coverage-above 1"));
  EXPECT_EQ(whole.at("coverage"), 1.0);
  EXPECT_EQ(whole.at("health"), "ok");
  const Outcome more = chasles(folder, "run rec --quiet --coverage-above 1.1");
  EXPECT_EQ(more.code, 5);
  expect_part(more.err, "missed: coverage is 1, asked for at least 1.1");
}

// The accelerometer measures nothing at first, so the run starts late.
TEST(Run, ThatEstimatesLessThanHalfOfTheFramesIsNotOk) {
  const Scratch folder;
  ASSERT_EQ(chasles(folder,
                    "simulate hallway -o rec --quiet --set hall_length=12 --set hall_width=8 "
                    "--set sections=2 --set frame_rate=10")
                .code,
            0);
  Recording recording = read_recording(folder / "rec");
  const std::size_t frames = frame_count(recording);
  const Time late = frame_time(recording, frames * 3 / 5);
  for (ImuSample& sample : recording.imu) {
    if (sample.time < late) sample.specific_force_imu.setZero();
  }
  write_folder_recording(recording, folder / "late");
  const Outcome run = chasles(folder, "run late --json --quiet");
  const Json summary = json_of(run);
  EXPECT_LT(summary.at("coverage"), 0.5);
  EXPECT_NEAR(summary.at("coverage").get<double>(),
              summary.at("frames").get<double>() / static_cast<double>(frames), 1e-9);
  EXPECT_EQ(summary.at("health"), "degraded");
  expect_part(summary.at("remarks").dump(),
              fmt::format("estimated {} of {} frames: the start was found only after ",
                          summary.at("frames").get<int>(), frames));
  // Other thresholds say nothing about the rest of the recording.
  const Outcome passed = chasles(folder, "run late --quiet --ate-below 1e9");
  EXPECT_EQ(passed.code, 5);
  expect_part(passed.err, "asked for at least 0.5 (--coverage-above)");
  EXPECT_EQ(chasles(folder, "run late --quiet --ate-below 1e9 --coverage-above 0.01").code, 0);
}

TEST(Run, SaysThatTheKernelsOfOpenBlasWereChosen) {
  const Scratch folder;
  simulate(folder);
  const Outcome outcome =
      chasles(folder, "run rec --json --quiet --stop 1", "export OPENBLAS_CORETYPE=Haswell; ");
  EXPECT_EQ(json_of(outcome).at("openblas_coretype"), "Haswell");
  expect_part(json_of(outcome).at("remarks").dump(), "OPENBLAS_CORETYPE=Haswell was set");
  EXPECT_FALSE(
      json_of(chasles(folder, "run rec --json --quiet --stop 1", "unset OPENBLAS_CORETYPE; "))
          .contains("openblas_coretype"));
}

TEST(Run, SettingsTakeTheLastWord) {
  const Scratch folder;
  simulate(folder);
  spill(folder / "c.yaml", "gate: 0.5\nchart: standard\nmin_disparity: 3\n");
  const Json s = json_of(chasles(folder,
                                 "run rec --json --quiet --stop 2 --chart left-se3 --set "
                                 "gate=0.6 --set chart=right-se3 --config c.yaml"))
                     .at("settings");
  EXPECT_EQ(s.at("min_disparity"), 3);
  EXPECT_EQ(s.at("gate"), 0.6);
  EXPECT_EQ(s.at("chart"), "left-se3");
  expect_error(chasles(folder, "run rec --quiet --config c.yaml --set chart=no"), 1,
               "--set: chart: found 'no'");
}

// A filter without landmarks in its state uses tracks only. It must not restart for this reason.
TEST(Run, WithTracksAloneGoesThroughInOnePart) {
  const Scratch folder;
  simulate_turntable(folder);
  const Json all = json_of(
      chasles(folder, "run rec --json --quiet --set max_landmarks=0 --set min_landmarks=0"));
  EXPECT_EQ(all.at("resets"), 0);
  EXPECT_EQ(all.at("health"), "ok");
  EXPECT_LT(all.at("ate_posyaw_m").get<double>(), 0.3);
  EXPECT_TRUE(all.at("nis_per_dof").is_null());
}

TEST(Run, StartAndStopCutTheRecording) {
  const Scratch folder;
  simulate(folder);
  const Json s = json_of(chasles(folder, "run rec --json --quiet --start 2 --stop 5"));
  EXPECT_EQ(s.at("frames"), 31);  // 10 Hz, including both ends
  EXPECT_NEAR(s.at("recorded_seconds").get<double>(), 3, 1e-9);
}

TEST(Run, FullCovarianceHasTheLandmarksOwnBlocksOnItsDiagonal) {
  const Scratch folder;
  simulate(folder);
  ASSERT_EQ(chasles(folder, "run rec --quiet --stop 6 -o out --full-covariance P.npy").code, 0);
  const auto run = read_run(folder / "out");
  const std::string npy = slurp(folder / "P.npy"), rows = slurp(folder / "P.csv");
  const std::size_t n = static_cast<std::size_t>(std::count(rows.begin(), rows.end(), '\n')) - 1;
  ASSERT_GE(n, 3 * run.landmarks.size() + 6);
  const std::size_t header = 10 + static_cast<unsigned char>(npy[8]) +
                             256 * static_cast<std::size_t>(static_cast<unsigned char>(npy[9]));
  EXPECT_EQ(header % 64, 0u);
  ASSERT_EQ(npy.size(), header + 8 * n * (n + 1) / 2);
  const auto entry = [&](std::size_t i, std::size_t j) {
    double value = 0;
    std::memcpy(&value, npy.data() + header + 8 * (i * (i + 1) / 2 + j), sizeof(value));
    return value;
  };
  std::istringstream names(rows);
  std::string line;
  std::getline(names, line);
  for (std::size_t k = 0; k < run.landmarks.size(); ++k) {
    const RunLandmark& l = run.landmarks[k];
    for (std::size_t i = 0; i < 3; ++i) {
      std::getline(names, line);
      EXPECT_EQ(line, std::to_string(3 * k + i) + "," + std::to_string(l.id) + "," + "xyz"[i]);
      for (std::size_t j = 0; j <= i; ++j) {
        const double expected = l.covariance(static_cast<int>(i), static_cast<int>(j));
        EXPECT_NEAR(entry(3 * k + i, 3 * k + j), expected, 1e-9 * l.covariance.trace());
      }
    }
  }
  // Two landmarks observed from the same poses share the errors of these poses.
  EXPECT_NE(entry(3, 0), 0);
}

TEST(Run, LocalizeIsDeadReckoning) {
  const Scratch folder;
  simulate(folder);
  ASSERT_EQ(chasles(folder, "run rec --quiet --mode localize -o out").code, 0);
  const Trajectory alone = read_tum(folder / "out/dead_reckoning.tum");
  const Trajectory estimate = read_tum(folder / "out/trajectory.tum");
  ASSERT_EQ(alone.size(), estimate.size());
  EXPECT_NEAR((alone.back().pose.p - estimate.back().pose.p).norm(), 0, 1e-9);
  EXPECT_EQ(json_of(chasles(folder, "run rec --json --quiet --mode localize")).at("landmarks"), 0);
}

TEST(Run, MapFollowsTheGivenTrajectoryAndFindsTheLandmarks) {
  const Scratch folder;
  simulate(folder);
  ASSERT_EQ(chasles(folder, "run rec --quiet --mode map --trajectory rec/truth.tum -o out").code,
            0);
  const Trajectory truth = read_tum(folder / "rec/truth.tum");
  const Trajectory estimate = read_tum(folder / "out/trajectory.tum");
  ASSERT_EQ(truth.size(), estimate.size());
  const SE3 start = truth.front().pose.inverse();
  for (std::size_t k = 0; k < truth.size(); ++k) {
    EXPECT_NEAR(((start * truth[k].pose).p - estimate[k].pose.p).norm(), 0, 1e-6);
  }
  std::map<LandmarkId, Eigen::Vector3d> known;
  for (const TrueLandmark& l : read_recording(folder / "rec").true_landmarks)
    known[l.id] = l.p_world;
  double well_placed = 0, compared = 0;
  for (const RunLandmark& l : read_run(folder / "out").landmarks) {
    if (l.observations < 5 || !known.count(l.id)) continue;
    const double error = (l.p_world - start * known[l.id]).norm();
    well_placed += error < 4 * std::sqrt(l.covariance.trace());
    ++compared;
  }
  ASSERT_GT(compared, 20);
  EXPECT_GT(well_placed / compared, 0.9);
}

TEST(Run, ThatDivergesEndsWithFourAndKeepsWhatThereWas) {
  const Scratch folder;
  simulate(folder);
  std::istringstream lines(slurp(folder / "rec/velocities.csv"));
  std::string text, line;
  for (int row = 0; std::getline(lines, line); ++row) {
    const std::string time = line.substr(0, line.find(','));
    text += (row == 50 || row == 51 ? time + ",1e308,1e308,1e308,0,0,0" : line) + "\n";
  }
  spill(folder / "rec/velocities.csv", text);
  const Outcome outcome = chasles(folder, "run rec --quiet --json -o out --mode localize");
  EXPECT_EQ(outcome.code, 4);
  expect_part(outcome.err, "chasles: error: the estimate was lost");
  const Json summary = Json::parse(outcome.out);
  EXPECT_EQ(summary.at("health"), "lost");
  EXPECT_TRUE(summary.at("ate_m").is_null());
  EXPECT_GT(summary.at("frames"), 40);
  EXPECT_LT(summary.at("frames"), 60);
  EXPECT_EQ(read_run(folder / "out").states.size(), summary.at("frames"));
}

TEST(Run, AnInterruptWritesWhatThereIs) {
  const Scratch folder;
  simulate(folder, "--set route=RRRRRRRRRRRR --set block_length=80 --set block_width=80");
  const std::string log = (folder / "log").string(), rec = (folder / "rec").string(),
                    out = (folder / "out").string();
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 2, log.c_str(), O_WRONLY | O_CREAT, 0644);
  std::vector<std::string> words = {"chasles", "run", rec, "-o", out};
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  // A test in the background of a shell inherits ignored interrupts.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t interrupt;
  sigemptyset(&interrupt);
  sigaddset(&interrupt, SIGINT);
  posix_spawnattr_setsigdefault(&attributes, &interrupt);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
  pid_t process = 0;
  ASSERT_EQ(posix_spawn(&process, CHASLES_BINARY, &actions, &attributes, argv.data(), environ), 0);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  // The line with the recording is logged between handler installation and first frame.
  while (slurp(log).find('\n') == std::string::npos) ::usleep(1000);
  ::kill(process, SIGINT);
  int status = 0;
  ASSERT_EQ(::waitpid(process, &status, 0), process);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  const Json summary = Json::parse(slurp(folder / "out/summary.json"));
  expect_part(summary.at("remarks").dump(), "interrupted after ");
  EXPECT_LT(summary.at("frames"), read_recording(folder / "rec").frames.size());
}

TEST(Report, WritesOnePageForSeveralRuns) {
  const Scratch folder;
  simulate(folder);
  ASSERT_EQ(chasles(folder, "run rec --quiet -o a").code, 0);
  ASSERT_EQ(chasles(folder, "run rec --quiet -o b --chart standard").code, 0);
  const Outcome outcome = chasles(folder, "report a b -o page.html");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const std::string page = slurp(folder / "page.html");
  expect_part(page, "realtime_factor");
  expect_part(page, "</html>");
}

TEST(RealRecording, OfKittiRunsWithoutAnOption) {
  const char* given = std::getenv("CHASLES_DATA");
  const std::filesystem::path data =
      (given ? std::filesystem::path(given)
             : std::filesystem::path(CHASLES_SOURCE_DIR) / ".." / "shared" / "data") /
      "kitti_tracks";
  if (!std::filesystem::exists(data)) GTEST_SKIP() << "skipped: no recordings";
  const Scratch folder;
  const std::string truth = (data / "ground_truth/0042_gt_imu_stars.tum").string();
  const Outcome outcome =
      chasles(folder, "run '" + (data / "ece276a_2018/0042.npz").string() + "' --truth '" + truth +
                          "' --quiet --ate-below 2.1 --rpe-below 1.21");
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
  expect_part(outcome.out, "the velocities are along level axes, not the IMU's");
  const Outcome rejected =
      chasles(folder, "run '" + (data / "ece276a_2018/0042.npz").string() +
                          "' --quiet --mode localize --set velocity_axes=level -o rejected");
  EXPECT_EQ(rejected.code, 1);
  expect_part(rejected.err, "velocity_axes=level");
}

}  // namespace
}  // namespace chasles::test
