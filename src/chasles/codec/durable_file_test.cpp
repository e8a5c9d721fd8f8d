#include <fcntl.h>
#include <unistd.h>

#include <sys/stat.h>
#include <sys/wait.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/output_file.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/testing.hpp>

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

TEST(DurableFile, LinksAreFollowedAlsoToWhatIsNotThereYet) {
  const auto folder = test::scratch();
  fs::create_directory(folder / "sub");
  fs::create_symlink("sub/real", folder / "second");
  fs::create_symlink(folder / "second", folder / "first");
  replace_file(folder / "first", "one");
  EXPECT_TRUE(fs::is_symlink(folder / "first") && fs::is_symlink(folder / "second"));
  EXPECT_EQ(test::slurp(folder / "sub/real"), "one");
  fs::create_symlink("loop", folder / "loop");
  fs::create_symlink("none/real", folder / "astray");
  const auto rejection = [&](const char* name) -> std::string {
    try {
      replace_file(folder / name, "one");
    } catch (const UsageError& error) {
      return error.what();
    }
    return "written";
  };
  EXPECT_NE(rejection("loop").find("leads back to itself"), std::string::npos) << rejection("loop");
  EXPECT_NE(rejection("astray").find("there is no folder"), std::string::npos)
      << rejection("astray");
  EXPECT_TRUE(fs::is_symlink(folder / "loop"));
}

TEST(DurableFile, APipeWithoutAReaderIsRejectedAtOnce) {
  const auto folder = test::scratch();
  const fs::path pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THROW(replace_file(pipe, "one"), UsageError);
  EXPECT_THROW(reject_pipe(pipe), UsageError);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  replace_file(pipe, "one");
  char bytes[4] = {};
  EXPECT_EQ(::read(reader, bytes, sizeof bytes), 3);
  EXPECT_STREQ(bytes, "one");
  ::close(reader);
  EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST(DurableFile, APartThatAKilledProcessLeftIsUsedAgain) {
  const auto folder = test::scratch();
  test::spill(folder / "a.part", "the remains of a longer file");
  replace_file(folder / "a", "new");
  EXPECT_EQ(test::slurp(folder / "a"), "new");
  EXPECT_EQ(count_in(folder), 1U);
}

TEST(DurableFile, ProcessesHavePartsOfTheirOwn) {
  const auto folder = test::scratch();
  {
    PartFile first(folder / "a"), second(folder / "a");
    EXPECT_EQ(first.ending(), ".part");
    EXPECT_EQ(second.ending(), ".2.part");
    first.write("first");
    second.write("second");
    first.move_over();
    EXPECT_EQ(PartFile(folder / "a").ending(), ".part");
    second.move_over();
  }
  EXPECT_EQ(test::slurp(folder / "a"), "second");
  EXPECT_EQ(count_in(folder), 1U);
}

TEST(DurableFile, ManyProcessesReplaceItAsAWhole) {
  const auto folder = test::scratch();
  std::vector<pid_t> children;
  for (char letter = 'a'; letter < 'e'; ++letter) {
    children.push_back(::fork());
    if (children.back() != 0) continue;
    try {
      for (int i = 0; i < 50; ++i) replace_file(folder / "f", std::string(20'000, letter));
    } catch (const std::exception&) {
      ::_exit(1);
    }
    ::_exit(0);
  }
  for (const pid_t child : children) {
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
  }
  const std::string bytes = test::slurp(folder / "f");
  EXPECT_EQ(bytes, std::string(20'000, bytes.at(0)));
  EXPECT_EQ(count_in(folder), 1U);
}

TEST(FileSet, ProcessesWriteSetsOfTheirOwn) {
  const auto folder = test::scratch();
  FileSet first(folder, "mark"), second(folder, "mark");
  first.add("a", "1");
  second.add("mark", "2");
  second.add("a", "2");
  first.add("mark", "1");
  second.commit();
  EXPECT_EQ(test::slurp(folder / "a") + test::slurp(folder / "mark"), "22");
  first.commit();
  EXPECT_EQ(test::slurp(folder / "a") + test::slurp(folder / "mark"), "11");
  EXPECT_EQ(count_in(folder), 2U);
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
