#include <chasles/data/durable_file.hpp>
#include <chasles/data/testing.hpp>
#include <chasles/data/text_file.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

std::size_t count_in(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
}

TEST(DurableFile, IsReplacedAsAWhole) {
  const auto folder = test::scratch();
  replace_file(folder / "a", "one");
  replace_file(folder / "a", "two");
  EXPECT_EQ(test::slurp(folder / "a"), "two");
  EXPECT_EQ(count_in(folder), 1U);
}

TEST(DurableFile, ALinkStaysAndADeviceIsWrittenDirectly) {
  const auto folder = test::scratch();
  test::spill(folder / "real", "one");
  fs::create_symlink("real", folder / "link");
  replace_file(folder / "link", "two");
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(test::slurp(folder / "real"), "two");
  replace_file("/dev/null", "nothing");
  EXPECT_FALSE(fs::is_regular_file("/dev/null"));
  EXPECT_THROW(replace_file("/dev/full", "something"), UsageError);
  EXPECT_THROW(replace_file(folder, "a folder"), UsageError);
}

TEST(DurableFile, AFaultLeavesTheOldFile) {
  const auto folder = test::scratch();
  test::spill(folder / "a", "old");
  fs::create_directory(folder / "a.part");  // in the way
  EXPECT_THROW(replace_file(folder / "a", "new"), UsageError);
  EXPECT_EQ(test::slurp(folder / "a"), "old");
}

TEST(FileSet, ReplacesItsFilesTogether) {
  const auto folder = test::scratch();
  for (const char* name : {"a", "b", "mark", "foreign"}) test::spill(folder / name, "old");
  {
    FileSet given_up(folder, "mark");
    given_up.add("a", "new");
    given_up.add("mark", "new");
  }
  EXPECT_EQ(count_in(folder), 4U);
  EXPECT_EQ(test::slurp(folder / "a"), "old");
  FileSet files(folder, "mark");
  files.add("mark", "new");
  files.add("a", "new");
  files.remove("b");
  EXPECT_EQ(test::slurp(folder / "mark"), "old");
  files.commit();
  EXPECT_EQ(test::slurp(folder / "a") + test::slurp(folder / "mark"), "newnew");
  EXPECT_FALSE(fs::exists(folder / "b"));
  EXPECT_EQ(test::slurp(folder / "foreign"), "old");
  EXPECT_EQ(count_in(folder), 3U);
}

TEST(FileSet, AFaultOnTheWayLeavesNoMark) {
  const auto folder = test::scratch();
  for (const char* name : {"a", "mark"}) test::spill(folder / name, "old");
  fs::create_directories(folder / "b" / "in the way");
  FileSet files(folder, "mark");
  for (const char* name : {"a", "b", "mark"}) files.add(name, "new");
  EXPECT_THROW(files.commit(), UsageError);
  EXPECT_FALSE(fs::exists(folder / "mark"));
}

}  // namespace
}  // namespace chasles
