#include <algorithm>
#include <sstream>
#include <tuple>

#include <nlohmann/json.hpp>

#include <chasles/run_folder/run.hpp>

#include "cli_test.hpp"

// `chasles export`, and the files that `chasles run` writes for it.
namespace chasles::test {
namespace {

void simulate_and_run(const Scratch& folder) {
  simulate(folder);
  ASSERT_EQ(chasles(folder, "run rec -o out --quiet").code, 0);
}

TEST(Export, WritesWhatTheEndingsAskFor) {
  const Scratch folder;
  simulate_and_run(folder);
  const Outcome outcome = chasles(folder, "export out -o a/run.mcap -o run.ply");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("a/run.mcap: "), std::string::npos);
  const std::string mcap = slurp(folder / "a/run.mcap");
  EXPECT_TRUE(mcap.starts_with("\x89MCAP0\r\n") && mcap.ends_with("\x89MCAP0\r\n"));
  EXPECT_TRUE(slurp(folder / "run.ply").starts_with("ply\nformat binary_little_endian 1.0\n"));
  ASSERT_EQ(chasles(folder, "export out -o again.mcap --quiet").out, "");
  EXPECT_EQ(slurp(folder / "again.mcap"), mcap);
}

// The name of a folder may have any bytes, for example Latin-1.
TEST(Export, ARunInAFolderWhoseNameIsNotUtf8IsWrittenAndShown) {
  const Scratch folder;
  simulate(folder);
  const std::string calibration = slurp(folder / "rec/calibration.yaml");
  const std::size_t name = calibration.find("name:");
  spill(folder / "rec/calibration.yaml", calibration.substr(0, name) + "name: caf\xe9" +
                                             calibration.substr(calibration.find('\n', name)));
  const Outcome run = chasles(folder, "run rec -o caf\xe9 --json --quiet");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(nlohmann::json::parse(run.out).at("name"), "caf\xef\xbf\xbd");
  for (const char* what :
       {"report caf\xe9 -o page.html", "export caf\xe9 -o run.mcap -o run.ply"}) {
    const Outcome outcome = chasles(folder, what);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
  }
  EXPECT_NE(slurp(folder / "page.html").find("caf\xef\xbf\xbd"), std::string::npos);
}

TEST(Export, WhatCannotBeDoneIsSaid) {
  const Scratch folder;
  simulate_and_run(folder);
  Outcome outcome = chasles(folder, "export out -o run.kml");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("is not georeferenced"), std::string::npos) << outcome.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "run.kml"));
  outcome = chasles(folder, "export out -o run.bag");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.err.find(
                "expected .mcap, .ply, .kml, .square, .tum, .tlog, or --as with one of kitti,"),
            std::string::npos)
      << outcome.err;
  EXPECT_EQ(chasles(folder, "export rec -o run.ply").code, 2);
}

TEST(Export, TheFormatIsChosenByItsNameToo) {
  const Scratch folder;
  simulate_and_run(folder);
  for (const char* what :
       {"out --as tum -o poses.txt", "out -o poses.tum", "out --as kitti -o kitti",
        "out --as kitti -o kitti",  // replaces its files
        "out --as euroc -o data.csv", "out --as umi --recording rec -o umi.csv"}) {
    const Outcome outcome = chasles(folder, std::string("export ") + what);
    ASSERT_EQ(outcome.code, 0) << outcome.err;
  }
  EXPECT_TRUE(slurp(folder / "poses.tum") == slurp(folder / "poses.txt"));
  const auto lines = [](const std::string& text) { return std::ranges::count(text, '\n'); };
  const auto states = static_cast<long>(read_run(folder / "out").states.size());
  EXPECT_EQ(lines(slurp(folder / "kitti/poses.txt")), states);
  EXPECT_EQ(lines(slurp(folder / "kitti/times.txt")), states);
  EXPECT_EQ(lines(slurp(folder / "data.csv")), states + 1);
  EXPECT_GE(lines(slurp(folder / "umi.csv")), states + 1);
  // The project's own reader takes EuRoC's form.
  const Outcome evaluated = chasles(folder, "evaluate out/trajectory.tum data.csv");
  EXPECT_EQ(evaluated.code, 0) << evaluated.err;
}

TEST(Export, WhatAFormatLacksIsSaid) {
  const Scratch folder;
  simulate_and_run(folder);
  expect_error(chasles(folder, "export out --as tumm -o a"), 1,
               "--as: found 'tumm', expected "
               "mcap|ply|kml|square|tum|mavlink|kitti|euroc|mps|nerfstudio|colmap|"
               "colmap-text|umi");
  expect_error(chasles(folder, "export out --as tum -o a -o b"), 1, "found 2 outputs");
  expect_error(chasles(folder, "export out --as umi -o a"), 1, "expected --recording");
  expect_error(chasles(folder, "export out --as umi -o a --recording none"), 2, "none");
  expect_error(chasles(folder, "export out --as mps -o a"), 2, "does not know gravity");
  expect_error(chasles(folder, "export out --as mavlink -o a"), 2,
               "does not know which way is down, expected a run with an IMU");
  expect_error(chasles(folder, "export out --as mavlink -o a --body x,y,-z"), 1,
               "--body: found 'x,y,-z', expected");
  expect_error(chasles(folder, "export out --as nerfstudio -o a --recording rec"), 2,
               "has no images, expected one with the images of camera 0 as files");
  expect_error(chasles(folder, "export out --as colmap -o a"), 1,
               "--as colmap: the run folder does not have the frames");
  for (const char* as : {"nerfstudio", "colmap", "colmap --undistort", "nerfstudio --undistort"}) {
    expect_error(chasles(folder, std::string("export out -o a --recording rec --as ") + as), 2,
                 "has no images");
  }
  expect_error(chasles(folder, "export out --as colmap -o a --set overlap=2"), 1,
               "--set: overlap: found '2', expected");
  std::filesystem::create_directory(folder / "model");
  spill(folder / "model/cameras.bin", "");
  expect_error(chasles(folder, "export out --as colmap-text -o model --recording rec"), 1,
               "model has a binary model, which COLMAP reads instead");
  spill(folder / "file", "");
  expect_error(chasles(folder, "export out --as kitti -o file"), 1,
               "file: the folder cannot be made");
  expect_error(chasles(folder, "export out --as tum -o rec"), 1, "rec");
  EXPECT_FALSE(std::filesystem::exists(folder / "a"));
}

// The packages of python/tests/interop read the files; here is what the command says of them.
TEST(Export, AModelForColmapHasTheTracksOfKeyframes) {
  const Scratch folder;
  ASSERT_EQ(chasles(folder,
                    "simulate walk --images --quiet -o rec --set walk_duration=6 --set cameras=2 "
                    "--set image_width=320 --set image_height=240 --set focal_length=200 --set "
                    "center_u=159.5 --set center_v=119.5")
                .code,
            0);
  ASSERT_EQ(chasles(folder, "run rec -o out --quiet").code, 0);
  const auto keyframes = [&](const std::string& more) {
    const Outcome outcome =
        chasles(folder, "export out --as colmap -o model --recording rec" + more);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const std::size_t at = outcome.out.find("\n- ");
    EXPECT_NE(at, std::string::npos) << outcome.out;
    return std::stoi(outcome.out.substr(at + 3));
  };
  const int usual = keyframes("");
  const std::string images = slurp(folder / "model/images.bin");
  const std::string priors = slurp(folder / "model/database.db");
  EXPECT_GT(usual, 1);
  EXPECT_GT(keyframes(" --set overlap=0.95 --set search=0"), usual);
  EXPECT_EQ(keyframes(""), usual);
  EXPECT_TRUE(slurp(folder / "model/images.bin") == images) << "the same bytes";
  EXPECT_TRUE(slurp(folder / "model/database.db") == priors);
  EXPECT_NE(images.find("mav0/cam1/data/"), std::string::npos);
  ASSERT_EQ(chasles(folder, "export out --as colmap-text -o text --recording rec --quiet").code, 0);
  const std::string text = slurp(folder / "text/frames.txt");
  EXPECT_EQ(std::ranges::count(text, '\n'), usual + 1);
  // A run of the second camera alone.
  ASSERT_EQ(chasles(folder, "run rec -o one --cameras 1 --quiet").code, 0);
  ASSERT_EQ(chasles(folder, "export one --as colmap -o single --recording rec --quiet").code, 0);
  const std::string of_one = slurp(folder / "single/images.bin");
  EXPECT_NE(of_one.find("mav0/cam1/data/"), std::string::npos);
  EXPECT_EQ(of_one.find("mav0/cam0/data/"), std::string::npos);
  // Nothing is a point.
  expect_error(chasles(folder,
                       "export out --as colmap -o none --recording rec --set "
                       "min_observations=1000"),
               2, "no track is a point");
  // A summary of which the front end's settings cannot be used.
  std::string summary = slurp(folder / "out/summary.json");
  const std::string right = "\"frontend.window\": 15";
  ASSERT_NE(summary.find(right), std::string::npos);
  summary.replace(summary.find(right), right.size(), "\"frontend.window\": 99");
  spill(folder / "out/summary.json", summary);
  expect_error(chasles(folder, "export out --as colmap -o none --recording rec"), 2,
               "summary.json: settings: frontend.window: found '99'");
}

TEST(Export, AStateMayBeAskedForAtOtherTimes) {
  const Scratch folder;
  simulate_turntable(folder);
  ASSERT_EQ(chasles(folder, "run rec -o out --quiet").code, 0);
  const auto run = read_run(folder / "out");
  const Time first = run.states.front().time, last = run.states.back().time;
  const auto exported = [&](const std::string& more) {
    const Outcome outcome = chasles(folder, "export out -o path.tum" + more);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.out;
  };
  // In the middle between two states, and outside of the path.
  const auto middle = [](const RunState& a, const RunState& b) {
    return a.time + (b.time - a.time) / 2;
  };
  const Time time = middle(run.states[3], run.states[4]);
  spill(folder / "times.csv", "time,x\n# comment\n" + std::to_string(time.count()) + ",7\n" +
                                  std::to_string((last + std::chrono::seconds(1)).count()) + "\n");
  EXPECT_NE(exported(" --times times.csv").find("- states at 1 of 2 times, interpolated"),
            std::string::npos);
  double seconds = 0, x = 0;
  std::string head;
  std::istringstream tum(slurp(folder / "path.tum"));
  ASSERT_TRUE(std::getline(tum, head) && head.starts_with('#'));
  tum >> seconds >> x;
  EXPECT_NEAR(seconds, to_seconds(time), 1e-9);
  EXPECT_NEAR(x, (run.states[3].world_T_imu.p.x() + run.states[4].world_T_imu.p.x()) / 2, 1e-9);
  const auto lines = [&] {
    const std::string text = slurp(folder / "path.tum");
    return std::ranges::count(text, '\n') - 1;
  };
  exported(" --rate 50");
  EXPECT_EQ(lines(), static_cast<long>(to_seconds(last - first) * 50 + 1e-6) + 1);
  exported(" --rate 50 --smoothed");
  EXPECT_EQ(lines(), static_cast<long>(to_seconds(last - first) * 50 + 1e-6) + 1);
  // At each sample of the IMU in between.
  const std::string remark = exported(" --rate imu --recording rec");
  EXPECT_NE(remark.find("samples of the IMU, predicted from the state before; at 0 there is none"),
            std::string::npos)
      << remark;
  EXPECT_GT(lines(), 3 * static_cast<long>(run.states.size()));
  for (const auto& [more, code, message] :
       {std::tuple(" -o a.tum --rate imu", 1, "--rate imu: expected --recording"),
        std::tuple(" -o a.tum --rate imu --smoothed --recording rec", 1,
                   "no velocities and biases"),
        std::tuple(" -o a.tum --rate 0", 1, "--rate: found '0', expected imu, or a number of Hz"),
        std::tuple(" -o a.tum --rate 10Hz", 1, "--rate: found '10Hz'"),
        std::tuple(" -o a.tum --rate 5 --times times.csv", 1, "found both"),
        std::tuple(" -o a.ply --rate 5", 1,
                   "for formats of a path, found ply, expected one of square"),
        std::tuple(" -o a.tum --times none.csv", 2, "none.csv")}) {
    expect_error(chasles(folder, std::string("export out") + more), code, message);
  }
  spill(folder / "times.csv", "2\n1\n");
  expect_error(chasles(folder, "export out -o a.tum --times times.csv"), 2,
               "times.csv: time 2 is not later than the one before");
  spill(folder / "times.csv", "# nothing\n");
  expect_error(chasles(folder, "export out -o a.tum --times times.csv"), 2, "has no times");
  spill(folder / "times.csv", "1.5e9\n");
  expect_error(chasles(folder, "export out -o a.tum --times times.csv"), 2,
               "at none of the 1 times is a state known");
}

TEST(Export, PosesWithCovariancesAndTheirTruthAreOfOnePath) {
  const Scratch folder;
  simulate_turntable(folder);
  ASSERT_EQ(chasles(folder, "run rec -o out --quiet").code, 0);
  for (const char* path : {"", " --smoothed"}) {
    const Outcome outcome =
        chasles(folder, std::string("export out -o run.square --truth truth.tum --quiet") + path);
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const auto run = read_run(folder / "out");
    const Eigen::Vector3d& p =
        *path == '\0' ? run.states[1].world_T_imu.p : run.smoothed[1].world_T_imu.p;
    std::istringstream square(slurp(folder / "run.square")), truth(slurp(folder / "truth.tum"));
    std::string line, time, true_time;
    while (square.peek() == '#') std::getline(square, line);
    std::getline(truth, line);
    std::getline(truth, line);  // of the first pose, which SQUARE leaves out
    double x = 0, y = 0, z = 0;
    square >> time >> x >> y >> z;
    truth >> true_time;
    EXPECT_EQ(time, true_time);
    EXPECT_EQ(Eigen::Vector3d(x, y, z), p);
  }
  ASSERT_EQ(chasles(folder, "run rec --estimator batch -o batch --quiet").code, 0);
  expect_error(chasles(folder, "export batch --smoothed -o run.square"), 2, "has no smoothed.csv");
  // A truth of positions alone.
  std::istringstream poses(slurp(folder / "rec/truth.tum"));
  std::string positions;
  for (std::string line; std::getline(poses, line);) {
    std::istringstream words(line);
    std::string t, x, y, z;
    if (!line.starts_with('#') && words >> t >> x >> y >> z) {
      positions += t + " " + x + " " + y + " " + z + "\n";
    }
  }
  spill(folder / "positions.txt", positions);
  ASSERT_EQ(chasles(folder, "run rec --truth positions.txt -o position_run --quiet").code, 0);
  expect_error(chasles(folder, "export position_run -o p.square --truth truth.tum"), 2,
               "--truth: that of position_run has positions alone");
}

TEST(Export, ARunShowsWhenLandmarksWereSeenAndWhatStagesTook) {
  const Scratch folder;
  simulate_and_run(folder);
  const auto run = read_run(folder / "out");
  EXPECT_EQ(run.stage_names, (std::vector<std::string>{"propagation", "update", "landmarks"}));
  double stages = 0, frames = 0;
  for (const RunState& s : run.states) {
    for (const double stage : s.stages) {
      EXPECT_GE(stage, 0);
      stages += stage;
    }
    frames += s.milliseconds;
  }
  EXPECT_GT(stages, 0);
  EXPECT_LE(stages, 1.01 * frames) << "they are parts of the frames";
  int in_state = 0;
  for (const RunLandmark& l : run.landmarks) {
    EXPECT_GE(l.first_seen, run.states.front().time);
    EXPECT_LE(l.last_seen, run.states.back().time);
    EXPECT_LE(l.first_seen, l.last_seen);
    in_state += l.in_state;
  }
  EXPECT_EQ(in_state, run.states.back().in_state);
  EXPECT_LT(in_state, static_cast<int>(run.landmarks.size())) << "some have been retired";
}

}  // namespace
}  // namespace chasles::test
