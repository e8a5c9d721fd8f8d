#include <filesystem>
#include <unistd.h>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/many/batch_list.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

// A list in a folder of its own.
class BatchListTest : public ::testing::Test {
 protected:
  BatchListTest() { fs::create_directories(folder_); }
  ~BatchListTest() override { fs::remove_all(folder_); }

  std::vector<BatchItem> read(const std::string& text) {
    write_file(file(), text);
    return read_batch_list(file());
  }
  std::string error_of(const std::string& text) {
    try {
      read(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }
  fs::path file() const { return folder_ / "list"; }

  fs::path folder_ = fs::path(::testing::TempDir()) /
                     ("batch_list_" + std::to_string(getpid()) +
                      ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(BatchListTest, HasPathsAndObjects) {
  const auto items = read(
      "# of monday\n\nwalk\r\n"
      R"({"recording": "/abs/fly", "name": "f", "truth": "t.tum", "cameras": "mono", "start": 1.5,)"
      R"( "stop": 9, "set": {"chart": "standard", "gate": 0.95, "recognise": "none"}})");
  ASSERT_EQ(items.size(), 2u);
  EXPECT_EQ(items[0].recording, folder_ / "walk");
  EXPECT_EQ(items[1].recording, "/abs/fly");
  EXPECT_EQ(items[1].name, "f");
  EXPECT_EQ(items[1].truth, folder_ / "t.tum");
  EXPECT_EQ(items[1].cameras, "mono");
  EXPECT_EQ(items[1].start, 1.5);
  EXPECT_EQ(items[1].stop, 9);
  EXPECT_EQ(items[1].sets,
            (std::vector<std::string>{"chart=standard", "gate=0.95", "recognise=none"}));
}

TEST_F(BatchListTest, SaysWhatIsWrongAndWhere) {
  for (const auto& [text, part] :
       {std::pair{"\n{\"recording\": 3}", ":2: recording: found 3, expected a text"},
        {"{\"name\": \"a\"}", ":1: found no field 'recording'"},
        {"{\"recording\": \"a\", \"stop\": -1}", "stop: found -1, expected seconds"},
        {"{\"recording\": \"a\", \"set\": [1]}", "set: found [1], expected an object"},
        {"{\"recording\": \"a\", \"begin\": 1}", "unknown field 'begin'"},
        {"{\"recording\"", "expected a path or a JSON object"},
        {"# nothing\n", "found no recording"}}) {
    EXPECT_NE(error_of(text).find(part), std::string::npos) << error_of(text);
  }
  EXPECT_THROW(read_batch_list(folder_ / "none"), InputError);
}

std::vector<std::string> names_of(std::vector<BatchItem> items) {
  name_items(items);
  std::vector<std::string> names;
  for (const BatchItem& item : items) names.push_back(item.name);
  return names;
}

TEST(BatchNames, AreTheLastPartsAndMoreWhereTheyAreAlike) {
  EXPECT_EQ(names_of({{.recording = "/data/a/walk.bag"}, {.recording = "/data/b/fly/"}}),
            (std::vector<std::string>{"walk", "fly"}));
  EXPECT_EQ(names_of({{.recording = "/data/a/x/mav0"},
                      {.recording = "/data/b/x/mav0"},
                      {.recording = "/data/b/y"}}),
            (std::vector<std::string>{"a_x_mav0", "b_x_mav0", "y"}));
  EXPECT_EQ(names_of({{.recording = "/data/a", .name = "first"}, {.recording = "/data/b/first"}}),
            (std::vector<std::string>{"first", "b_first"}));
}

TEST(BatchItem, ThePathOfTheRecordIsAbsoluteAndText) {
  EXPECT_EQ((BatchItem{.recording = "/data/x/../a"}).said_source(), "/data/a");
  EXPECT_EQ((BatchItem{.recording = "/data/\xff"}).said_source(), "/data/\xEF\xBF\xBD");
  EXPECT_EQ((BatchItem{.recording = "/cache/1", .source = "s3://b/a"}).said_source(), "s3://b/a");
  EXPECT_EQ((BatchItem{.recording = "a", .stop = 2, .sets = {"x=1"}}).options_json().dump(),
            R"({"stop":2.0,"set":["x=1"]})");
}

TEST(BatchNames, ARecordingThatIsThereTwiceIsAnError) {
  EXPECT_THROW(names_of({{.recording = "/data/a"}, {.recording = "/data/../data/a"}}), UsageError);
  EXPECT_THROW(names_of({{.recording = "/a", .name = "x"}, {.recording = "/b", .name = "x"}}),
               UsageError);
  EXPECT_THROW(names_of({{.recording = "/a", .name = "../x"}}), UsageError);
  for (const std::string& name :
       {std::string(".."), std::string("a\nb"), std::string("a\0b", 3), std::string(201, 'x')}) {
    EXPECT_THROW(names_of({{.recording = "/a", .name = name}}), UsageError) << name;
  }
}

TEST(Shard, IsEveryNthOfAList) {
  EXPECT_TRUE(shard_from("").is_whole());
  const Shard shard = shard_from("2/3");
  EXPECT_FALSE(shard.is_whole());
  EXPECT_FALSE(shard.has(0));
  EXPECT_TRUE(shard.has(1));
  EXPECT_TRUE(shard.has(4));
  for (const char* wrong : {"0/3", "4/3", "1", "1/", "/3", "a/3", "1/3x", "-1/3"}) {
    EXPECT_THROW(shard_from(wrong), UsageError) << wrong;
  }
}

}  // namespace
}  // namespace chasles
