#include <fstream>
#include <map>
#include <sstream>

#include <nlohmann/json.hpp>

#include <chasles/recording/readers.hpp>
#include <chasles/recording/testing.hpp>
#include <chasles/run_folder/run.hpp>

namespace chasles {
namespace {

using test::expect_parts;
using test::input_error;

Run example_run() {
  test::Random random(11);
  Run run{.name = "example",
          .extra_names = {"velocity_x", "bias_z"},
          .stage_names = {"front_end", "update"},
          .states = {},
          .landmarks = {},
          .truth = {},
          .dead_reckoning = {}};
  for (int k = 0; k < 20; ++k) {
    RunState& s = run.states.emplace_back();
    s.time = Time(1317384506402997017 + 100'000'000LL * k);
    s.world_T_imu = {so3::exp({0.1 * k, 0.2, -0.3}), {random.normal(), random.normal(), 100.0 * k}};
    const Matrix6d A = Matrix6d::NullaryExpr([&] { return random.normal(); });
    s.pose_covariance = A * A.transpose();
    s.extra = {random.normal(), 1e-7};
    s.extra_sigma = {random.uniform(), 0.1};
    s.nis = random.uniform(0, 50);
    s.nis_dof = 4 * k;
    s.observations = 70 + k;
    s.used = 60;
    s.rejected = 3;
    s.added = k;
    s.in_state = 67;
    s.landmarks = 500 + k;
    s.health = k < 15 ? "ok" : "degraded";
    s.milliseconds = 0.25 * k;
    s.stages = {0.125 * k, 0.0625};
    run.truth.push_back({.time = s.time, .pose = s.world_T_imu});
  }
  for (int j = 0; j < 7; ++j) {
    RunLandmark& l = run.landmarks.emplace_back();
    l.id = 1000 * j;
    l.p_world = {random.normal(), random.normal(), j / 3.0};
    const Eigen::Matrix3d A = Eigen::Matrix3d::NullaryExpr([&] { return random.normal(); });
    l.covariance = A * A.transpose();
    l.observations = 5 + j;
    l.first_seen = Time(1317384506402997017 + j);
    l.last_seen = Time(1317384508402997017 + j);
    l.in_state = j % 2 == 1;
  }
  run.dead_reckoning = run.truth;
  for (const RunState& s : run.states) {
    run.smoothed.push_back({.time = s.time,
                            .world_T_imu = {s.world_T_imu.R, s.world_T_imu.p / 3},
                            .pose_covariance = s.pose_covariance / 3});
  }
  return run;
}

const nlohmann::ordered_json kRunSummary{
    {"name", "example"}, {"ate_m", 1.5}, {"nees_pose", nullptr}};

TEST(RunFolder, IsReadAgainAsItWasWritten) {
  const auto run = example_run();
  const auto folder = test::scratch() / "a" / "b";
  write_run(run, kRunSummary, folder);
  const auto again = read_run(folder);
  EXPECT_EQ(again.name, run.name);
  EXPECT_EQ(again.extra_names, run.extra_names);
  EXPECT_EQ(again.stage_names, run.stage_names);
  ASSERT_EQ(again.states.size(), run.states.size());
  for (std::size_t k = 0; k < run.states.size(); ++k) {
    const RunState &a = again.states[k], &b = run.states[k];
    EXPECT_EQ(a.time, b.time);
    EXPECT_EQ(a.world_T_imu.p, b.world_T_imu.p);
    EXPECT_LT((a.world_T_imu.R - b.world_T_imu.R).norm(), 1e-14);
    EXPECT_EQ(a.pose_covariance, Matrix6d(b.pose_covariance.selfadjointView<Eigen::Upper>()));
    EXPECT_EQ(a.extra, b.extra);
    EXPECT_EQ(a.extra_sigma, b.extra_sigma);
    EXPECT_EQ(a.nis, b.nis);
    EXPECT_EQ(a.health, b.health);
    EXPECT_EQ(a.milliseconds, b.milliseconds);
    EXPECT_EQ(a.stages, b.stages);
    EXPECT_EQ((std::vector{a.nis_dof, a.observations, a.used, a.rejected, a.added, a.in_state,
                           a.landmarks}),
              (std::vector{b.nis_dof, b.observations, b.used, b.rejected, b.added, b.in_state,
                           b.landmarks}));
  }
  ASSERT_EQ(again.landmarks.size(), run.landmarks.size());
  for (std::size_t j = 0; j < run.landmarks.size(); ++j) {
    EXPECT_EQ(again.landmarks[j].id, run.landmarks[j].id);
    EXPECT_EQ(again.landmarks[j].p_world, run.landmarks[j].p_world);
    EXPECT_EQ(again.landmarks[j].covariance,
              Eigen::Matrix3d(run.landmarks[j].covariance.selfadjointView<Eigen::Upper>()));
    EXPECT_EQ(again.landmarks[j].observations, run.landmarks[j].observations);
    EXPECT_EQ(again.landmarks[j].first_seen, run.landmarks[j].first_seen);
    EXPECT_EQ(again.landmarks[j].last_seen, run.landmarks[j].last_seen);
    EXPECT_EQ(again.landmarks[j].in_state, run.landmarks[j].in_state);
    EXPECT_FALSE(again.landmarks[j].initial);
  }
  ASSERT_EQ(again.smoothed.size(), run.smoothed.size());
  for (std::size_t k = 0; k < run.smoothed.size(); ++k) {
    const SmoothedPose &a = again.smoothed[k], &b = run.smoothed[k];
    EXPECT_EQ(a.time, b.time);
    EXPECT_EQ(a.world_T_imu.p, b.world_T_imu.p);
    EXPECT_LT((a.world_T_imu.R - b.world_T_imu.R).norm(), 1e-14);
    EXPECT_EQ(a.pose_covariance, Matrix6d(b.pose_covariance.selfadjointView<Eigen::Upper>()));
  }
  EXPECT_EQ(read_tum(folder / "trajectory_smoothed.tum").size(), run.smoothed.size());
  EXPECT_EQ(again.truth.size(), run.truth.size());
  EXPECT_EQ(again.dead_reckoning.size(), run.truth.size());
  EXPECT_EQ(read_summary(folder), kRunSummary);
  EXPECT_FALSE(std::filesystem::exists(folder / "timing.json"));
  EXPECT_EQ(read_tum(folder / "trajectory.tum").size(), run.states.size());
}

// The heading at a start is exact, and its variance 0 but for rounding.
TEST(RunFolder, AVarianceBelowZeroByRoundingHasASigmaOfZero) {
  auto run = example_run();
  run.states[0].pose_covariance(2, 2) = -1.4e-29;
  const auto folder = test::scratch();
  write_run(run, kRunSummary, folder);
  std::ifstream file(folder / "states.csv");
  std::map<std::string, std::string> fields;
  std::string head, row, name, value;
  std::getline(file, head);
  std::getline(file, row);
  std::istringstream names(head), values(row);
  while (std::getline(names, name, ',') && std::getline(values, value, ',')) fields[name] = value;
  EXPECT_EQ(fields.at("sigma_rz"), "0");
  EXPECT_EQ(fields.at("cov_22"), "-1.4e-29");
}

nlohmann::ordered_json placed_summary() {
  nlohmann::ordered_json summary = kRunSummary;
  summary["place_in_map"] = {
      {"world_T_map", {{"position_m", {1.5, -2, 0.25}}, {"quaternion_xyzw", {0, 0, 0.6, 0.8}}}},
      {"sessions",
       {{{"name", "hall, monday"},
         {"begin_ns", 5},
         {"end_ns", 1317384506402997017},
         {"cameras", 2}}}}};
  return summary;
}

TEST(RunFolder, TheMapOfARunIsReadAgain) {
  auto run = example_run();
  run.prior_map.emplace().points = {{.id = 1'000'000'003,
                                     .session = 0,
                                     .p_map = {1.0 / 3, 2, -4},
                                     .covariance = run.landmarks[0].covariance,
                                     .own = 0.125,
                                     .observations = 12,
                                     .views = 3}};
  const auto folder = test::scratch() / "run";
  write_run(run, placed_summary(), folder);
  const auto again = read_run(folder).prior_map;
  ASSERT_TRUE(again);
  EXPECT_EQ(again->world_T_map.p, Eigen::Vector3d(1.5, -2, 0.25));
  EXPECT_LT(
      (again->world_T_map.R * Eigen::Vector3d::UnitX() - Eigen::Vector3d(0.28, 0.96, 0)).norm(),
      1e-12);
  ASSERT_EQ(again->sessions.size(), 1u);
  EXPECT_EQ(again->sessions[0].name, "hall, monday");
  EXPECT_EQ(again->sessions[0].end.count(), 1317384506402997017);
  ASSERT_EQ(again->points.size(), 1u);
  const SketchPoint &a = again->points[0], &b = run.prior_map->points[0];
  EXPECT_EQ(a.p_map, b.p_map);
  EXPECT_EQ(a.covariance, Eigen::Matrix3d(b.covariance.selfadjointView<Eigen::Upper>()));
  EXPECT_EQ((std::tuple{a.id, a.session, a.own, a.observations, a.views}),
            (std::tuple{b.id, b.session, b.own, b.observations, b.views}));
}

TEST(RunFolder, AMapThatDoesNotFitTheSummaryIsRejected) {
  auto run = example_run();
  run.prior_map.emplace().points.resize(1);
  run.prior_map->points[0].session = 1;
  const auto folder = test::scratch() / "run";
  write_run(run, placed_summary(), folder);
  expect_parts(input_error([&] { read_run(folder); }),
               {"prior_map.csv", "1 is no session of the map, which has 1"});
  write_run(run, kRunSummary, folder);
  expect_parts(input_error([&] { read_run(folder); }), {"place_in_map", "expected world_T_map"});
}

TEST(RunFolder, InitialPositionsAreReadAgainWhereTheyAreKnown) {
  auto run = example_run();
  for (std::size_t j = 0; j < 3; ++j) {
    RunLandmark& l = run.landmarks[j];
    l.initial = {.p_world = 2 * l.p_world, .covariance = 3 * l.covariance};
  }
  const auto folder = test::scratch() / "run";
  write_run(run, kRunSummary, folder);
  const auto again = read_run(folder);
  for (std::size_t j = 0; j < run.landmarks.size(); ++j) {
    const auto &read = again.landmarks[j].initial, &written = run.landmarks[j].initial;
    ASSERT_EQ(read.has_value(), written.has_value()) << j;
    if (!written) continue;
    EXPECT_EQ(read->p_world, written->p_world);
    EXPECT_EQ(read->covariance,
              Eigen::Matrix3d(written->covariance.selfadjointView<Eigen::Upper>()));
  }
}

TEST(RunFolder, OnlyTheTimingDiffersBetweenRunsOfDifferentSpeed) {
  const auto folder = test::scratch();
  auto run = example_run();
  write_run(run, kRunSummary, folder / "a");
  for (RunState& state : run.states) {
    state.milliseconds *= 2;
    for (double& stage : state.stages) stage *= 2;
  }
  write_run(run, kRunSummary, folder / "b");
  std::vector<std::string> different;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "a")) {
    const auto name = entry.path().filename();
    if (test::slurp(entry.path()) != test::slurp(folder / "b" / name)) different.push_back(name);
  }
  EXPECT_EQ(different, std::vector<std::string>{"timing.csv"});
}

TEST(RunFolder, TheTimesOfTheWholeRunAreTakenLast) {
  const auto folder = test::scratch();
  const auto written = write_run(example_run(), kRunSummary, folder, [&] {
    EXPECT_TRUE(std::filesystem::exists(folder / ".writing/map.ply"));
    EXPECT_FALSE(std::filesystem::exists(folder / "map.ply"));
    return std::string("{}\n");
  });
  EXPECT_EQ(test::slurp(folder / "timing.json"), "{}\n");
  EXPECT_EQ(written, nlohmann::ordered_json::parse(test::slurp(folder / "summary.json")));
}

TEST(RunFolder, FilesThatAreNotThoseOfTheSummaryAreRejected) {
  const auto root = test::scratch(), folder = root / "run", other = root / "other";
  const auto error = [&](const std::string& file, const auto& spoil) {
    write_run(example_run(), kRunSummary, folder);
    spoil(folder / file);
    return input_error([&] { read_run(folder); });
  };
  const auto truncate = [](const auto& file) {
    const std::string text = test::slurp(file);
    test::spill(file, text.substr(0, text.rfind('\n', text.size() - 2) + 1));  // a whole last line
  };
  for (const char* file :
       {"trajectory.tum", "states.csv", "landmarks.csv", "map.ply", "dead_reckoning.tum"}) {
    expect_parts(error(file, truncate), {file, "bytes", "copy the folder again, or run again"});
  }
  expect_parts(error("truth.tum", [](const auto& file) { std::filesystem::remove(file); }),
               {"truth.tum", "summary.json lists it"});
  auto longer = example_run();
  longer.states.back().nis = 17;
  write_run(longer, kRunSummary, other);
  const auto of_another = [&](const auto& file) {
    std::filesystem::copy_file(other / file.filename(), file,
                               std::filesystem::copy_options::overwrite_existing);
  };
  expect_parts(error("states.csv", of_another), {"states.csv", "of another run"});
  expect_parts(error("summary.json",
                     [](const auto& file) { test::spill(file, R"({"files": {"../x": 3}})"); }),
               {"../x", "cannot be read"});
  expect_parts(
      error("summary.json", [](const auto& file) { test::spill(file, R"({"files": 3})"); }),
      {"summary.json", "'files'"});
}

TEST(RunFolder, AFolderOfAnEarlierVersionIsComparedByItsNumberOfFrames) {
  const auto folder = test::scratch();
  write_run(example_run(), kRunSummary, folder);
  test::spill(folder / "summary.json", R"({"frames": 20})");
  EXPECT_EQ(read_run(folder).states.size(), 20U);
  test::spill(folder / "summary.json", R"({"frames": 21})");
  expect_parts(input_error([&] { read_run(folder); }), {"states.csv", "20 rows", "21 frames"});
}

TEST(RunFolder, ARunThatWentWrongCanStillBeRead) {
  auto run = example_run();
  run.states.back().nis = INFINITY;
  run.states.back().pose_covariance(1, 1) = NAN;
  run.states.back().world_T_imu.p.x() = NAN;
  run.states.back().world_T_imu.R.setConstant(NAN);
  const auto folder = test::scratch();
  write_run(run, kRunSummary, folder);
  const RunState last = read_run(folder).states.back();
  EXPECT_EQ(last.nis, INFINITY);
  EXPECT_TRUE(std::isnan(last.pose_covariance(1, 1)));
  EXPECT_TRUE(std::isnan(last.world_T_imu.p.x()));
  EXPECT_TRUE(std::isnan(last.world_T_imu.R(0, 0)));
}

TEST(RunFolder, ThePointCloudHoldsEveryLandmark) {
  const auto run = example_run();
  const auto folder = test::scratch();
  write_run(run, kRunSummary, folder);
  const std::string ply = test::slurp(folder / "map.ply");
  expect_parts(ply, {"ply\nformat binary_little_endian 1.0\n", "element vertex 7\n"});
  const std::string end = "end_header\n";
  const std::size_t body = ply.find(end) + end.size();
  ASSERT_EQ(ply.size() - body, 7u * 4 * sizeof(float));
  float numbers[4];
  std::memcpy(numbers, ply.data() + body + 3 * sizeof(numbers), sizeof(numbers));
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(numbers[axis], static_cast<float>(run.landmarks[3].p_world[axis]));
  }
  EXPECT_NEAR(numbers[3], std::sqrt(run.landmarks[3].covariance.trace()), 1e-6);
}

TEST(RunFolder, TruthAndSmoothedPathOfAnEarlierRunDoNotStay) {
  auto run = example_run();
  const auto folder = test::scratch();
  write_run(run, kRunSummary, folder);
  run.truth.clear();
  run.smoothed.clear();
  write_run(run, kRunSummary, folder);
  EXPECT_TRUE(read_run(folder).truth.empty());
  EXPECT_TRUE(read_run(folder).smoothed.empty());
  EXPECT_FALSE(std::filesystem::exists(folder / "trajectory_smoothed.tum"));
}

TEST(RunFolder, TheNameComesFromTheFolderWhereTheSummaryHasNone) {
  const auto folder = test::scratch() / "v1.5";
  write_run(example_run(), {{"ate_m", 1}}, folder);
  EXPECT_EQ(read_run(folder / "").name, "v1.5");
}

TEST(RunFolder, WhereItIsOnTheEarthComesFromTheSummary) {
  const auto folder = test::scratch();
  const auto written = [&](const nlohmann::ordered_json& where) {
    write_run(example_run(), {{"name", "x"}, {"georeference", where}}, folder);
  };
  written({{"latitude", 49.5}, {"longitude", 8.25}, {"altitude", 110}});
  const auto run = read_run(folder);
  ASSERT_TRUE(run.georeference);
  EXPECT_EQ(run.georeference->origin.latitude, 49.5);
  EXPECT_EQ(run.georeference->origin.longitude, 8.25);
  EXPECT_EQ(run.georeference->origin.altitude, 110);
  written({{"latitude", 99}, {"longitude", 8.25}, {"altitude", 110}});
  expect_parts(input_error([&] { read_run(folder); }),
               {"summary.json: georeference", "'latitude'"});
  written(7);
  expect_parts(input_error([&] { read_run(folder); }), {"summary.json: georeference"});
}

TEST(RunFolder, DamageIsNamed) {
  const auto folder = test::scratch();
  const auto error = [&](const std::string& file, const std::string& from, const std::string& to) {
    write_run(example_run(), kRunSummary, folder);
    test::spill(folder / "summary.json", kRunSummary.dump());  // lists no files
    std::string text = test::slurp(folder / file);
    text.replace(text.find(from), from.size(), to);
    test::spill(folder / file, text);
    return input_error([&] { read_run(folder); });
  };
  expect_parts(error("states.csv", "nis_dof", "nisdof"), {"states.csv:1: has the columns"});
  expect_parts(error("states.csv", "sigma_bias_z", "bias_sigma"),
               {"states.csv:1: has the columns"});
  expect_parts(error("states.csv", ",ok\n", "\n"), {"states.csv:2: has", "values, expected"});
  expect_parts(error("timing.csv", "\n1317384506402997017,", "\n7,"),
               {"timing.csv:2: expected the row of 1317384506402997017 ns"});
  expect_parts(error("timing.csv", "update_ms", "update"),
               {"timing.csv:1: has the columns", "NAME_ms"});
  expect_parts(error("landmarks.csv", "\n1000,", "\n1e3,"),
               {"landmarks.csv:3: column 'landmark': found '1e3', expected an integer"});
  expect_parts(error("summary.json", "{", "("), {"summary.json: is not valid JSON"});
  expect_parts(input_error([&] { read_run(folder / "none"); }), {"none: is no run folder"});
}

TEST(RunFolder, AStateWithoutItsExtraNumbersIsAMistakeOfTheCaller) {
  auto run = example_run();
  run.states[4].extra.pop_back();
  EXPECT_THROW(write_run(run, kRunSummary, test::scratch()), std::invalid_argument);
}

TEST(RunFolder, AFileInTheWayIsReported) {
  const auto folder = test::scratch();
  test::spill(folder / "file", "x");
  EXPECT_THROW(write_run(example_run(), kRunSummary, folder / "file"), UsageError);
}

}  // namespace
}  // namespace chasles
