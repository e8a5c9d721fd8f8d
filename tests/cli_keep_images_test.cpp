#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include <nlohmann/json.hpp>

#include <chasles/recording/readers.hpp>
#include <chasles/run_folder/run.hpp>

#include "cli_test.hpp"

// `chasles run --keep-images`.
namespace chasles::test {
namespace {

namespace fs = std::filesystem;

// Its list of the run's files has those of the images.
std::string without_check_sums(const std::string& summary) {
  auto json = nlohmann::ordered_json::parse(summary);
  EXPECT_EQ(json.erase("files"), 1u);
  return json.dump();
}

std::map<std::string, std::string> files_of(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder).string();
    if (entry.is_regular_file() && !name.starts_with("timing")) files[name] = slurp(entry.path());
    if (name == "summary.json") files[name] = without_check_sums(files[name]);
  }
  return files;
}

TEST(KeepImages, TheyAreTheSameBytesWithOneThreadAndThreeAndChangeNothingElse) {
  const Scratch folder;
  ASSERT_EQ(chasles(folder, "simulate walk --images --set walk_duration=6 -o walk --quiet").code,
            0);
  for (const char* run : {"--threads 1 -o one --keep-images 7",
                          "--threads 3 -o three --keep-images 7", "--threads 2 -o none"}) {
    const Outcome outcome = chasles(folder, std::string("run walk --quiet ") + run);
    ASSERT_EQ(outcome.code, 0) << outcome.err;
  }
  const auto one = files_of(folder / "one");
  EXPECT_EQ(one, files_of(folder / "three"));
  for (const auto& [name, bytes] : files_of(folder / "none")) {
    EXPECT_EQ(one.at(name), bytes) << name;
  }

  const auto run = read_run(folder / "one");
  ASSERT_EQ(run.images.size(), (read_recording(folder / "walk").images->size() + 6) / 7);
  std::map<chasles::Outcome, int> outcomes;
  // A state's time is the IMU's, an image's the camera's: they differ by the time offset.
  const Time offset = std::chrono::milliseconds(20);
  const auto state_of = [&](const ShownImage& image) {
    return std::ranges::find_if(run.states, [&](const RunState& s) {
      return std::chrono::abs(s.time - image.time) < offset;
    });
  };
  for (const ShownImage& image : run.images) {
    EXPECT_GT(image.jpeg.size(), 2000u);
    EXPECT_LT(image.jpeg.size(), 40'000u) << "the limit of --help";
    int used = 0, rejected = 0;
    for (const ImageFeature& f : image.features) {
      ++outcomes[f.seen.outcome];
      used += f.seen.outcome == chasles::Outcome::kUsed;
      rejected += f.seen.outcome == chasles::Outcome::kRejected;
      const Eigen::Vector2d& p = f.seen.observation.pixel;
      EXPECT_TRUE(p.x() >= 0 && p.y() >= 0 && p.x() < image.width && p.y() < image.height);
    }
    const auto state = state_of(image);
    if (state == run.states.end()) {
      EXPECT_LT(image.time, run.states.front().time) << "before the start";
      EXPECT_EQ(used + rejected, 0);
      continue;
    }
    EXPECT_EQ(used, state->used);
    EXPECT_EQ(rejected, state->rejected);
  }
  EXPECT_GT(outcomes[chasles::Outcome::kUsed], 100);
  EXPECT_GT(outcomes[chasles::Outcome::kWaiting], 100);

  ASSERT_EQ(chasles(folder, "report one -o with.html --quiet").code, 0);
  ASSERT_EQ(chasles(folder, "report none -o without.html --quiet").code, 0);
  EXPECT_NE(slurp(folder / "with.html").find("\"/9j/"), std::string::npos);
  EXPECT_EQ(slurp(folder / "without.html").find("\"/9j/"), std::string::npos);

  // A later run without kept images removes them.
  ASSERT_EQ(chasles(folder, "run walk --quiet -o one").code, 0);
  EXPECT_EQ(files_of(folder / "one"), files_of(folder / "none"));
}

TEST(KeepImages, OfTracksThePointsAloneAreKept) {
  const Scratch folder;
  ASSERT_EQ(chasles(folder, "simulate hallway -o walk --quiet").code, 0);
  const Outcome outcome = chasles(folder,
                                  "run walk --stop 12 --begin truth --quiet --keep-images "
                                  "-o run");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_FALSE(fs::exists(folder / "run/images"));
  const auto run = read_run(folder / "run");
  EXPECT_GT(run.images.size(), 50u);
  EXPECT_LE(run.images.size(), 200u) << "the limit of --help";
  EXPECT_GT(run.images.back().features.size(), 3u);
  ASSERT_EQ(chasles(folder, "report run -o page.html --quiet").code, 0);
}

TEST(KeepImages, WhatCannotBeIsRejected) {
  const Scratch folder;
  ASSERT_EQ(chasles(folder, "simulate street-ins -o street --quiet").code, 0);
  for (const char* n : {"0", "-3", "2.5", "99999999999", "all"}) {
    expect_error(chasles(folder, std::string("run street -o run --keep-images=") + n), 1,
                 "--keep-images: found '" + std::string(n) + "', expected a number of frames");
  }
  expect_error(chasles(folder, "run street --keep-images"), 1, "--keep-images needs -o RUN");
  expect_error(chasles(folder, "run street -o run --keep-images --quiet"), 1,
               "--keep-images is for a recording with an IMU");
}

}  // namespace
}  // namespace chasles::test
