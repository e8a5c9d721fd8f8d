#include <nlohmann/json.hpp>

#include <chasles/recording/plan.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/testing.hpp>
#include <chasles/run_folder/run.hpp>

namespace chasles {
namespace {

using test::expect_parts;
using test::input_error;
using test::scratch;
using test::spill;

Plan example_plan() {
  return {{.kind = PlanLine::Kind::kWall, .points = {{0, 0}, {1.0 / 3, 0}, {4, -2e-7}, {0, 0}}},
          {.kind = PlanLine::Kind::kFurniture, .points = {{1e3, 2}, {-1.5, 0.1}}},
          {.kind = PlanLine::Kind::kWall, .points = {{5, 5}, {6, 6}}}};
}

void expect_equal(const Plan& a, const Plan& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].kind, b[i].kind);
    EXPECT_EQ(a[i].points, b[i].points);
  }
}

std::string error_of(const std::string& text) {
  const auto file = scratch() / "plan.csv";
  spill(file, text);
  return input_error([&] { read_plan(file); });
}

TEST(Plan, IsReadAgainAsItWasWritten) {
  const auto folder = scratch();
  EXPECT_TRUE(read_plan_of(folder).empty()) << "no file, no plan";
  write_plan_of(example_plan(), folder);
  expect_equal(read_plan_of(folder), example_plan());
  write_plan_of({}, folder);
  EXPECT_FALSE(std::filesystem::exists(folder / "plan.csv"));
}

TEST(Plan, ATableWithoutRowsIsAPlanWithoutLines) {
  const auto folder = scratch();
  spill(folder / "plan.csv", "line,kind,x,y\n");
  EXPECT_TRUE(read_plan_of(folder).empty());
}

TEST(Plan, WhatIsMalformedIsNamedWithItsPlace) {
  const std::string head = "line,kind,x,y\n0,wall,0,0\n0,wall,1,0\n";
  expect_parts(error_of("line,x,y\n"), {"plan.csv", "line,x,y", "line,kind,x,y"});
  expect_parts(error_of(head + "1,roof,0,0\n"), {"plan.csv:4", "kind", "'roof'", "furniture"});
  expect_parts(error_of(head + "3,wall,0,0\n"), {"plan.csv:4", "found 3", "expected 0 or 1"});
  expect_parts(error_of(head + "1,wall,0,0\n1,wall,1,1\n0,wall,2,2\n"), {"plan.csv:6", "found 0"});
  expect_parts(error_of("line,kind,x,y\n1,wall,0,0\n"), {"plan.csv:2", "found 1", "expected 0"});
  expect_parts(error_of("line,kind,x,y\n-1,wall,0,0\n"), {"plan.csv:2", "found -1", "expected 0"});
  expect_parts(error_of(head + "0,furniture,0,0\n"), {"plan.csv:4", "'furniture'", "'wall'"});
  expect_parts(error_of(head + "1,wall,0,nan\n"), {"plan.csv:4", "'y'", "nan"});
  expect_parts(error_of(head + "1,wall,0\n"), {"plan.csv:4"});
  expect_parts(error_of(head + "1,wall,0,0\n"), {"plan.csv", "line 1", "one point"});
  expect_parts(error_of(head + "1,wall,0,0\n2,wall,0,0\n"), {"plan.csv:5", "line 1", "one point"});
  expect_parts(error_of(head + "1,wall,0,0\n1,wall,3"), {"plan.csv", "truncated"});
}

TEST(Plan, ARunFolderKeepsIt) {
  chasles::Run run;  // Test::Run hides the class name
  run.name = "walk";
  run.plan = example_plan();
  const auto folder = scratch();
  write_run(run, {{"name", "walk"}}, folder);
  expect_equal(read_run(folder).plan, example_plan());
  run.plan.clear();
  write_run(run, {{"name", "walk"}}, folder);
  EXPECT_TRUE(read_run(folder).plan.empty()) << "that of an earlier run was left";
}

TEST(Plan, ARecordingFolderKeepsIt) {
  Recording recording;
  recording.name = "walk";
  recording.rig.fx = recording.rig.fy = recording.rig.baseline = 1;
  recording.plan = example_plan();
  const auto folder = scratch();
  write_folder_recording(recording, folder);
  expect_equal(read_recording(folder).plan, example_plan());
  recording.plan.clear();
  write_folder_recording(recording, folder);
  EXPECT_TRUE(read_recording(folder).plan.empty());
}

}  // namespace
}  // namespace chasles
