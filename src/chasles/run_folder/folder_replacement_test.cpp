#include <map>

#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/testing.hpp>
#include <chasles/run_folder/folder_replacement.hpp>
#include <chasles/run_folder/growing_run.hpp>
#include <chasles/run_folder/run.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

Run small_run(int states, bool with_truth) {
  Run run;
  run.name = "small";
  for (int k = 0; k < states; ++k) {
    RunState& s = run.states.emplace_back();
    s.time = Time(1'000'000'000LL + k);
    s.pose_covariance.setIdentity();
    s.health = "ok";
    if (with_truth) run.truth.push_back({.time = s.time, .pose = s.world_T_imu});
  }
  return run;
}

ShownImage picture_at(int nanoseconds) {
  return {.time = Time(nanoseconds),
          .camera = 0,
          .width = 4,
          .height = 3,
          .jpeg = "no real picture",
          .features = {}};
}

std::map<std::string, std::string> all_files(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) {
      files[entry.path().lexically_relative(folder)] = test::slurp(entry.path());
    }
  }
  return files;
}

// A folder as a kill leaves it after the new run is complete: the old run, and the new one beside
// it.
void leave_committed(const fs::path& folder) {
  write_run(small_run(5, true), {{"run", "old"}}, folder);
  const fs::path other = folder.parent_path() / "new";
  write_run(small_run(3, false), {{"run", "new"}}, other, [] { return std::string("{}\n"); });
  fs::rename(other, folder / ".written");
}

TEST(FolderReplacement, FilesOfTheEarlierRunGoAndNothingElse) {
  const auto folder = test::scratch() / "out";
  auto run = small_run(5, true);
  run.images = {picture_at(1), picture_at(2)};
  write_run(run, {}, folder);
  for (const char* mine : {"plan.csv", "images/cam0_7.jpg", "images/mine.txt", "notes.txt"}) {
    test::spill(folder / mine, "mine");
  }
  test::spill(folder.parent_path() / "truth.tum", "mine");
  // A summary that was changed by hand may name any file.
  auto summary = nlohmann::ordered_json::parse(test::slurp(folder / "summary.json"));
  summary["files"]["../truth.tum"] = nullptr;
  test::spill(folder / "summary.json", summary.dump());
  run = small_run(3, false);
  run.images = {picture_at(2)};
  write_run(run, {}, folder);
  EXPECT_FALSE(fs::exists(folder / "truth.tum"));
  EXPECT_FALSE(fs::exists(folder / "images/cam0_1.jpg"));
  EXPECT_TRUE(fs::exists(folder / "images/cam0_2.jpg"));
  for (const char* mine : {"plan.csv", "images/cam0_7.jpg", "images/mine.txt", "notes.txt"}) {
    EXPECT_TRUE(fs::exists(folder / mine)) << mine;
  }
  EXPECT_TRUE(fs::exists(folder.parent_path() / "truth.tum"));
}

TEST(FolderReplacement, AFolderWithoutARunKeepsItsFiles) {
  const auto folder = test::scratch() / "mine";
  fs::create_directories(folder);
  test::spill(folder / "plan.csv", "mine");
  write_run(small_run(3, false), {}, folder);
  EXPECT_EQ(test::slurp(folder / "plan.csv"), "mine");
}

TEST(FolderReplacement, AFileInTheWayOfAFolderIsRejectedBeforeAnythingChanges) {
  const auto folder = test::scratch() / "out";
  write_run(small_run(5, true), {}, folder);
  test::spill(folder / "images", "a file");
  const auto before = all_files(folder);
  auto run = small_run(3, false);
  run.images = {picture_at(1)};
  EXPECT_THROW(write_run(run, {}, folder), UsageError);
  EXPECT_EQ(all_files(folder), before);
}

TEST(FolderReplacement, AKillAfterTheCommitLeavesTheNewRunToItsFirstReader) {
  const auto folder = test::scratch() / "out";
  leave_committed(folder);
  const auto expected = all_files(folder / ".written");
  // Any of the steps may have been done already.
  for (std::size_t moved = 0; moved < expected.size() + 2; ++moved) {
    fs::remove_all(folder);
    leave_committed(folder);
    // Before them those of the old run alone, and its summary, are removed.
    if (moved > 0) fs::remove(folder / "truth.tum");
    if (moved > 1) fs::remove(folder / "summary.json");
    std::size_t count = 0;
    for (const auto& [name, bytes] : expected) {
      if (name == "summary.json" || moved < 2 || ++count > moved - 2) continue;
      fs::rename(folder / ".written" / name, folder / name);
    }
    EXPECT_EQ(read_run(folder).states.size(), 3U) << moved;
    EXPECT_EQ(all_files(folder), expected) << moved;
  }
}

TEST(FolderReplacement, ASummaryThatNestsWithoutEndIsRejected) {
  const auto folder = test::scratch() / "out";
  leave_committed(folder);
  test::spill(folder / ".written/summary.json", "{\"files\":" + std::string(200, '['));
  test::expect_parts(test::input_error([&] { read_run(folder); }),
                     {"summary.json: nests more than 100 values"});
}

TEST(FolderReplacement, AKillBeforeTheCommitLeavesTheOldRun) {
  const auto folder = test::scratch() / "out";
  write_run(small_run(5, true), {{"run", "old"}}, folder);
  write_file(folder / "notes.txt", "of the user");
  const auto before = all_files(folder);
  make_folder(folder / ".writing");
  write_file(folder / ".writing/states.csv", "cut o");
  EXPECT_EQ(read_run(folder).states.size(), 5U);
  { const GrowingRun next(folder); }
  EXPECT_EQ(all_files(folder), before) << "the next run removes the remains when it begins";
}

TEST(FolderReplacement, AnExceptionLeavesTheOldRun) {
  const auto folder = test::scratch() / "out";
  write_run(small_run(5, true), {{"run", "old"}}, folder);
  const auto before = all_files(folder);
  EXPECT_THROW(write_run(small_run(3, true), {{"run", "new"}}, folder,
                         []() -> std::string { throw UsageError("a full disk"); }),
               UsageError);
  EXPECT_EQ(all_files(folder), before);
  EXPECT_FALSE(fs::exists(folder / ".writing"));
}

TEST(FolderReplacement, FilesOfTheUserStayAndThoseOfTheOldRunGo) {
  const auto folder = test::scratch() / "out";
  auto old = small_run(5, true);
  old.images = {picture_at(1), picture_at(2)};
  write_run(old, {{"run", "old"}}, folder, [] { return std::string("{}\n"); });
  write_file(folder / "notes.txt", "of the user");
  write_file(folder / "images/sketch.jpg", "of the user");
  auto next = small_run(3, false);
  next.images = {picture_at(2)};
  write_run(next, {{"run", "new"}}, folder);
  const auto files = all_files(folder);
  EXPECT_TRUE(files.contains("notes.txt"));
  EXPECT_TRUE(files.contains("images/sketch.jpg"));
  EXPECT_TRUE(files.contains("images/cam0_2.jpg"));
  for (const char* gone : {"images/cam0_1.jpg", "truth.tum", "timing.json"}) {
    EXPECT_FALSE(files.contains(gone)) << gone;
  }
}

TEST(FolderReplacement, AFolderInTheWayLeavesTheOldRun) {
  const auto folder = test::scratch() / "out";
  write_run(small_run(5, false), {{"run", "old"}}, folder);
  make_folder(folder / "truth.tum" / "of the user");
  const auto before = all_files(folder);
  try {
    write_run(small_run(3, true), {{"run", "new"}}, folder);
    FAIL() << "it was written";
  } catch (const UsageError& error) {
    test::expect_parts(error.what(), {"truth.tum", "in the way"});
  }
  EXPECT_EQ(all_files(folder), before);
}

TEST(FolderReplacement, WorksThroughALinkAndInAFolderThatCannotBeRenamed) {
  const auto root = test::scratch(), real = root / "real", link = root / "link";
  make_folder(real);
  fs::create_directory_symlink(real, link);
  write_run(small_run(5, true), {{"run", "old"}}, link);
  write_run(small_run(3, true), {{"run", "new"}}, link / ".");
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(read_run(real).states.size(), 3U);
}

}  // namespace
}  // namespace chasles
