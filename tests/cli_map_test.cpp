#include <nlohmann/json.hpp>
#include <sys/stat.h>

#include "cli_process.hpp"
#include "cli_test.hpp"

// Maps as files: `chasles run --save-map`, `--map`, `--extend`, and `chasles map`.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

// A walk along a corridor in small images; the same building and path with other steps, or another
// building.
void simulate_walk(const Scratch& folder, const std::string& name, const std::string& more) {
  const Outcome made =
      chasles(folder, "simulate hallway --images --quiet -o " + name +
                          " --set hall_length=8 --set sections=1 --set rest_duration=1 --set "
                          "frame_rate=10 --set focal_length=200 --set image_width=320 --set "
                          "image_height=240 --set center_u=159.5 --set center_v=119.5 " +
                          more);
  ASSERT_EQ(made.code, 0) << made.err;
}

TEST(MapCommand, AMapIsSavedFoundExtendedAndDescribed) {
  const Scratch folder;
  simulate_walk(folder, "first", "");
  simulate_walk(folder, "second", "--set step_rate=1.5");
  const Outcome saved = chasles(folder, "run first --save-map m.map");
  ASSERT_EQ(saved.code, 0) << saved.err;
  EXPECT_NE(saved.out.find("map: m.map, "), std::string::npos) << saved.out;

  const Outcome described = chasles(folder, "map m.map");
  ASSERT_EQ(described.code, 0) << described.err;
  EXPECT_NE(described.out.find("session                first: "), std::string::npos)
      << described.out;
  const Json before = Json::parse(chasles(folder, "map m.map --json").out);
  EXPECT_GT(before.at("landmarks"), 30);
  EXPECT_LT(before.at("bytes").get<double>() / before.at("landmarks").get<double>(), 1000);
  EXPECT_GT(before.at("median_sigma_m"), 0);
  const Outcome drawn = chasles(folder, "map m.map -o pages/map.html");
  EXPECT_EQ(drawn.out, "page: pages/map.html\n") << drawn.err;
  EXPECT_NE(slurp(folder / "pages/map.html").find("\"name\":\"first\""), std::string::npos);
  EXPECT_EQ(chasles(folder, "map m.map -o map.ply").out, "ply: map.ply\n");
  EXPECT_EQ(slurp(folder / "map.ply").find("ply\n"), 0u);
  expect_error(chasles(folder, "map m.map -o map.png"), 1, "'map.png', expected a file name that");

  const Outcome placed = chasles(folder, "run second --map m.map -o run --json");
  ASSERT_EQ(placed.code, 0) << placed.err;
  const Json place = Json::parse(placed.out).at("place_in_map");
  EXPECT_TRUE(place.at("placed_ns").is_number()) << place;
  EXPECT_LT(std::abs(place.at("world_T_map").at("position_m")[0].get<double>()), 0.3);
  EXPECT_TRUE(std::filesystem::exists(folder / "run/trajectory_in_map.tum"));
  EXPECT_EQ(slurp(folder / "run/in_map.csv").find("time_ns,x,y,z"), 0u);
  EXPECT_EQ(slurp(folder / "run/prior_map.csv").find("landmark,session,x,y,z"), 0u);
  EXPECT_EQ(place.at("sessions")[0].at("name"), "first");
  EXPECT_GT(place.at("placed_seconds"), 0);
  const Json closures = Json::parse(placed.out).at("closures");
  ASSERT_FALSE(closures.empty());
  for (const Json& closure : closures) {
    EXPECT_EQ(closure.at("chi2_dof"), 2 * closure.at("landmarks").get<int>());
    EXPECT_GT(closure.at("chi2"), 0);
    EXPECT_LT(closure.at("chi2"), 10 * closure.at("chi2_dof").get<double>());
  }
  EXPECT_EQ(chasles(folder, "report run -o page.html").code, 0);
  EXPECT_NE(slurp(folder / "page.html").find("\"returned\""), std::string::npos);
  EXPECT_EQ(chasles(folder, "export run -o run.mcap -o run.ply").code, 0);

  const std::string unchanged = slurp(folder / "m.map");
  ASSERT_EQ(chasles(folder, "run second --map m.map --save-map other.map").code, 0);
  EXPECT_EQ(slurp(folder / "m.map"), unchanged);
  ASSERT_EQ(chasles(folder, "run second --map m.map --extend").code, 0);
  EXPECT_EQ(slurp(folder / "m.map"), slurp(folder / "other.map"));
  const Json after = Json::parse(chasles(folder, "map m.map --json").out);
  EXPECT_EQ(after.at("sessions").size(), 2u);
  EXPECT_GT(after.at("landmarks"), before.at("landmarks"));
}

TEST(MapCommand, MergesInAnyOrderToTheSameBytes) {
  const Scratch folder;
  simulate_walk(folder, "first", "");
  simulate_walk(folder, "second", "--set step_rate=1.5 --run 2");
  simulate_walk(folder, "third", "--set step_rate=1.75 --run 3");
  ASSERT_EQ(chasles(folder, "run first --save-map a.map --quiet").code, 0);
  ASSERT_EQ(chasles(folder, "run second --save-map b.map --quiet").code, 0);
  ASSERT_EQ(chasles(folder, "run third --save-map c.map --quiet").code, 0);
  const auto merged = [&](const std::string& maps, const std::string& output) {
    const Outcome outcome = chasles(folder, "map merge " + maps + " -o " + output);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return slurp(folder / output);
  };
  const std::string all = merged("a.map b.map c.map", "abc.map");
  EXPECT_TRUE(merged("c.map a.map b.map", "cab.map") == all);
  const std::string ab = merged("a.map b.map", "ab.map");
  EXPECT_TRUE(merged("b.map a.map", "ba.map") == ab);
  EXPECT_TRUE(merged("c.map ab.map", "m.map") == all);
  merged("c.map b.map", "bc.map");
  EXPECT_TRUE(merged("ab.map bc.map", "m.map") == all);
  EXPECT_TRUE(merged("a.map a.map", "m.map") == slurp(folder / "a.map"));

  const Outcome described = chasles(folder, "map merge b.map a.map -o ab.map");
  EXPECT_NE(described.out.find("landmarks that both have, NIS "), std::string::npos)
      << described.out;
  EXPECT_NE(described.out.find("maps merged in it      2\n"), std::string::npos) << described.out;
  const Json json = Json::parse(chasles(folder, "map merge c.map ab.map -o m.map --json").out);
  EXPECT_EQ(json.at("parts"), 3);
  ASSERT_EQ(json.at("joined").size(), 2u);
  EXPECT_GT(json.at("joined")[0].at("matches"), 10);
  EXPECT_EQ(Json::parse(chasles(folder, "map m.map --json").out).at("parts"), 3);

  // A run in a merged map, and one that began in a map of it.
  ASSERT_EQ(chasles(folder, "run third --map ab.map --save-map abt.map --quiet").code, 0);
  EXPECT_EQ(Json::parse(chasles(folder, "map abt.map --json").out).at("parts"), 1);
  expect_error(chasles(folder, "map merge a.map abt.map -o no.map"), 2, "count it twice");
  EXPECT_FALSE(std::filesystem::exists(folder / "no.map"));
}

// Both open the map before one of them has saved it; which one ends first is left to chance.
TEST(MapCommand, TwoRunsThatExtendOneMapLoseNothing) {
  const Scratch folder;
  simulate_walk(folder, "first", "");
  simulate_walk(folder, "second", "--set step_rate=1.5 --run 2");
  simulate_walk(folder, "third", "--set step_rate=1.75 --run 3");
  ASSERT_EQ(chasles(folder, "run first --save-map opened.map --quiet").code, 0);
  std::string expected;
  for (int together = 0, tries = 0; together < 3 && tries < 12; ++tries) {
    std::filesystem::copy_file(folder / "opened.map", folder / "m.map",
                               std::filesystem::copy_options::overwrite_existing);
    const std::string map = (folder / "m.map").string();
    const auto words = [&](const char* name) {
      return std::vector<std::string>{"run", (folder / name).string(), "--map", map, "--save-map",
                                      map};
    };
    const bool second_first = tries % 2 == 0;
    Process one(folder, words(second_first ? "second" : "third"), "log1");
    Process two(folder, words(second_first ? "third" : "second"), "log2");
    EXPECT_EQ(one.code_after(0), 0) << one.output();
    EXPECT_EQ(two.code_after(0), 0) << two.output();
    EXPECT_EQ(Json::parse(chasles(folder, "map m.map --json").out).at("sessions").size(), 3u);
    EXPECT_FALSE(std::filesystem::exists(map + ".part"));
    const std::string said = one.output() + two.output();
    if (said.find("with 1 session that other runs added meanwhile") == std::string::npos) continue;
    ++together;
    if (expected.empty()) expected = slurp(map);
    EXPECT_TRUE(slurp(map) == expected) << tries;
  }
  EXPECT_FALSE(expected.empty());
}

TEST(MapCommand, ALinkStaysAPipeIsRejectedAndNamesCommandNoTerminal) {
  const Scratch folder;
  simulate_walk(folder, "first", "");
  std::filesystem::create_symlink("real.map", folder / "link.map");
  std::filesystem::create_symlink("loop.map", folder / "loop.map");
  ASSERT_EQ(::mkfifo((folder / "pipe.map").c_str(), 0600), 0);
  const std::string quick = "timeout 20 ";
  expect_error(chasles(folder, "run first --save-map pipe.map", quick), 1, "pipe.map: is a pipe");
  expect_error(chasles(folder, "run first --save-map loop.map", quick), 1, "leads back to itself");
  ASSERT_EQ(chasles(folder, "run first --save-map link.map --quiet").code, 0);
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.map"));
  EXPECT_TRUE(std::filesystem::is_regular_file(folder / "real.map"));
  expect_error(chasles(folder, "map merge real.map real.map -o pipe.map", quick), 1, "is a pipe");
  expect_error(chasles(folder, "map real.map -o page.html", "mkfifo page.html && " + quick), 1,
               "a pipe that no program reads");
  std::filesystem::rename(folder / "first", folder / "f\x1b[31m");
  ASSERT_EQ(chasles(folder, "run f* --save-map red.map --quiet").code, 0);
  const Outcome described = chasles(folder, "map red.map");
  EXPECT_EQ(described.out.find('\x1b'), std::string::npos);
  EXPECT_NE(described.out.find("f\\u001b[31m: "), std::string::npos) << described.out;
}

TEST(MapCommand, AMapOfAnotherPlaceIsNotExtended) {
  const Scratch folder;
  simulate_walk(folder, "first", "");
  simulate_walk(folder, "other", "--seed 2");
  ASSERT_EQ(chasles(folder, "run first --save-map m.map --quiet").code, 0);
  const std::string before = slurp(folder / "m.map");
  const Outcome outcome = chasles(folder, "run other --map m.map --extend -o run");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_NE(outcome.err.find("found no place in m.map"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.out.find("place in the map            not found"), std::string::npos)
      << outcome.out;
  EXPECT_EQ(slurp(folder / "m.map"), before);
  EXPECT_TRUE(std::filesystem::exists(folder / "run/trajectory.tum"));
  EXPECT_FALSE(std::filesystem::exists(folder / "run/trajectory_in_map.tum"));
  // Without --extend nothing is missing.
  EXPECT_EQ(chasles(folder, "run other --map m.map").code, 0);
  ASSERT_EQ(chasles(folder, "run other --save-map o.map --quiet").code, 0);
  expect_error(chasles(folder, "map merge o.map m.map -o x.map"), 2, "no place in common with");
}

TEST(MapCommand, WhatCannotBeDoneIsSaid) {
  const Scratch folder;
  simulate(folder);
  spill(folder / "foreign.map", "ply\n");
  expect_error(chasles(folder, "map foreign.map"), 2, "foreign.map: is no map of Chasles");
  expect_error(chasles(folder, "map none.map"), 2, "none.map");
  expect_error(chasles(folder, "map"), 1, "expected a MAP");
  expect_error(chasles(folder, "map merge foreign.map foreign.map -o m.map"), 2, "is no map");
  expect_error(chasles(folder, "map merge foreign.map -o m.map"), 1, "MAPS");
  expect_error(chasles(folder, "run rec --save-map m.map"), 1, "for a recording with an IMU");
  expect_error(chasles(folder, "run rec --extend"), 1, "--map");
  simulate_turntable(folder);
  expect_error(chasles(folder, "run rec --save-map m.map"), 1, "needs images");
  expect_error(chasles(folder, "run rec --save-map m.map --estimator batch"), 1, "for the filter");
  expect_error(chasles(folder, "run rec --map m.map --extend --save-map n.map"), 1,
               "expected one of them");
}

TEST(MapCommand, TheOutputIsCheckedBeforeTheRun) {
  const Scratch folder;
  simulate_walk(folder, "first", "");
  std::filesystem::create_directory(folder / "sub");
  expect_error(chasles(folder, "run first --save-map sub"), 1, "is a folder");
  expect_error(chasles(folder, "run first --save-map no/m.map"), 1, "there is no folder no");
  spill(folder / "foreign.map", "ply\n");
  expect_error(chasles(folder, "run first --map foreign.map"), 2, "is no map of Chasles");
}

}  // namespace
}  // namespace chasles::test
