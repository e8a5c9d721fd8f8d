#include <cstdlib>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>

#include <chasles/bags/bag_contents.hpp>
#include <chasles/codec/bomb_testing.hpp>
#include <chasles/codec/gzip.hpp>
#include <chasles/codec/json_text.hpp>
#include <chasles/codec/read_budget.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/yaml_map.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/testing.hpp>
#include <chasles/run_folder/run.hpp>

// Files of a few bytes that claim gigabytes, nest without end, or never end.
namespace chasles {
namespace {

using test::BombStopwatch;
using test::expect_parts;
using test::input_error;

/// An environment variable for the running test.
class Variable {
 public:
  Variable(const char* name, const char* value) : name_(name) { ::setenv(name, value, 1); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;
  ~Variable() { ::unsetenv(name_); }

 private:
  const char* name_;
};

TEST(ReadBudget, IsSetByTheEnvironment) {
  EXPECT_EQ(read_budget().bytes, 512u << 20);
  EXPECT_EQ(read_budget().depth, 100);
  for (const auto& [text, bytes] : std::vector<std::pair<const char*, std::size_t>>{
           {"1", 1}, {"3K", 3 << 10}, {"20M", 20 << 20}, {"4G", std::size_t{4} << 30}}) {
    const Variable variable("CHASLES_READ_MEMORY", text);
    EXPECT_EQ(read_budget().bytes, bytes) << text;
  }
  const Variable depth("CHASLES_READ_DEPTH", "7");
  EXPECT_EQ(read_budget().depth, 7);
}

TEST(ReadBudget, AValueThatIsNoneIsRejected) {
  for (const char* text : {"", "0", "-1", "1.5G", "2T", "4GB", "99999999999G", "much"}) {
    const Variable variable("CHASLES_READ_MEMORY", text);
    EXPECT_THROW(read_budget(), UsageError) << text;
  }
  for (const char* text : {"", "0", "100000"}) {
    const Variable variable("CHASLES_READ_DEPTH", text);
    EXPECT_THROW(read_budget(), UsageError) << text;
  }
}

TEST(ReadBudget, AFileLargerThanItIsRejected) {
  const auto file = test::scratch() / "a.tum";
  test::spill(file, std::string(2000, '#'));
  EXPECT_EQ(read_file(file).size(), 2000u);
  const Variable variable("CHASLES_READ_MEMORY", "1K");
  expect_parts(input_error([&] { read_file(file); }),
               {"a.tum: has 2000 bytes", "more than the 1024 bytes", "CHASLES_READ_MEMORY"});
}

TEST(ReadBudget, OnlyRegularFilesAreRead) {
  const auto pipe = test::scratch() / "pipe.tum";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  expect_parts(input_error([&] { read_tum(pipe); }), {"pipe.tum: is a pipe or a device"});
  expect_parts(input_error([&] { read_recording(pipe); }), {"pipe.tum: is a pipe or a device"});
  expect_parts(input_error([&] { read_mat_recording(pipe); }), {"pipe.tum: is a pipe or a device"});
  expect_parts(input_error([&] { read_npz_recording(pipe); }), {"pipe.tum: is a pipe or a device"});
  expect_parts(input_error([] { read_recording("/dev/zero"); }), {"/dev/zero: is a pipe"});
  expect_parts(input_error([] { read_file("/dev/zero"); }), {"/dev/zero: is a pipe"});
}

TEST(ReadBudget, OfAGzipFileCountsWhatItClaims) {
  const auto file = test::scratch() / "a.tum.gz";
  test::spill(file, test::gzip_claiming(1'000'000'000, 1'000'000));
  const BombStopwatch quick;
  expect_parts(
      input_error([&] { read_tum(file); }),
      {"a.tum.gz: claims 1000000000 bytes from 1000000 compressed ones", "CHASLES_READ_MEMORY"});
}

TEST(ReadBudget, OfTracksCountsTheObservations) {
  const auto file = test::scratch() / "a.npz";
  test::NpzFields fields;
  constexpr std::size_t kFrames = 20, kTracks = 500;
  std::vector<double> times, features(4 * kFrames * kTracks, 0);
  for (std::size_t k = 0; k < kFrames; ++k) times.push_back(0.1 * static_cast<double>(k));
  fields["time_stamps"] = {{1, kFrames}, times};
  fields["linear_velocity"] =
      fields["rotational_velocity"] = {{3, kFrames}, std::vector<double>(3 * kFrames)};
  fields["K"] = {{3, 3}, {700, 0, 600, 0, 700, 180, 0, 0, 1}};
  fields["b"] = {{1}, {0.5}};
  fields["features"] = {{4, kTracks, kFrames}, features};
  test::write_npz(file, fields);
  const Variable variable("CHASLES_READ_MEMORY", "1M");
  expect_parts(input_error([&] { read_npz_recording(file); }),
               {"a.npz: field 'features': has more than 2621 observations", "CHASLES_READ_MEMORY"});
}

TEST(ReadBudget, OfABagCountsTheChunks) {
  const auto bags = std::filesystem::path(CHASLES_SOURCE_DIR) / "src/chasles/bags/testdata";
  EXPECT_EQ(scan_bags({bags / "none.bag"}).files.size(), 1u);
  const Variable variable("CHASLES_READ_MEMORY", "5K");
  expect_parts(input_error([&] { scan_bags({bags / "none.bag"}); }),
               {"none.bag: a part at byte", "more than the 5120 bytes", "CHASLES_READ_MEMORY"});
  expect_parts(input_error([&] { scan_bags({bags / "lz4.bag"}); }),
               {"lz4.bag", "expected at most"});
}

TEST(Json, BracketsInsideEachOtherAreCounted) {
  const BombStopwatch quick;
  for (const std::string& open : {std::string("["), std::string("{\"a\":")}) {
    std::string text;
    for (int i = 0; i < 100'000; ++i) text += open;
    expect_parts(input_error([&] { parse_json(text, "x.json"); }),
                 {"x.json: nests more than 100 values inside each other", "CHASLES_READ_DEPTH"});
  }
  const std::string whole = std::string(100, '[') + std::string(100, ']');
  EXPECT_TRUE(parse_json(whole, "x.json").is_array());
  expect_parts(input_error([&] { parse_json("[" + whole + "]", "x.json"); }), {"nests more"});
}

TEST(Json, NumbersBeyondADoubleAndDamageAreNamed) {
  expect_parts(input_error([] { parse_json(R"({"ate_m": 1e999})", "x.json"); }),
               {"x.json: is not valid JSON", "1e999"});
  expect_parts(input_error([] { parse_json(R"({"ate_m": )", "x.json"); }), {"is not valid JSON"});
  expect_parts(input_error([] { parse_json_object("[1]", "x.json"); }), {"expected a JSON object"});
  EXPECT_EQ(parse_json(R"({"a": [1, {"b": 2.5}]})", "x.json")["a"][1]["b"], 2.5);
}

TEST(Json, TooManyKeysOrValuesAreRejected) {
  const BombStopwatch quick;
  std::string keys = "{";
  for (int i = 0; i < 100'000; ++i) keys += fmt::format("\"{}\":0,", i);
  expect_parts(input_error([&] { parse_json(keys, "x.json"); }), {"more than 10000 keys"});
  std::string object = "{";
  for (int i = 0; i < 9'999; ++i) object += fmt::format("\"{}\":0,", i);
  object += "\"\":0}";
  EXPECT_EQ(parse_json(object, "x.json").size(), 10'000u);
  std::string many = "[" + object;
  for (int i = 0; i < 50; ++i) many += "," + object;
  expect_parts(input_error([&] { parse_json(many + "]", "x.json"); }),
               {"x.json: too many objects have thousands of keys"});
  std::string objects = "[{}";
  for (int i = 0; i < 100'000; ++i) objects += ",{}";
  EXPECT_EQ(parse_json(objects + "]", "x.json").size(), 100'001u);
  const Variable variable("CHASLES_READ_MEMORY", "1M");
  std::string values = "[0";
  for (int i = 0; i < 100'000; ++i) values += ",0";
  expect_parts(input_error([&] { parse_json(values + "]", "x.json"); }),
               {"x.json: has more than 32768 values", "CHASLES_READ_MEMORY"});
}

TEST(Yaml, ManyKeysTakeTimeInProportion) {
  const auto file = test::scratch() / "a.yaml";
  std::string text;
  for (int i = 0; i < 100'000; ++i) text += fmt::format("key_{}: 0\n", i);
  test::spill(file, text);
  const BombStopwatch quick;
  expect_parts(input_error([&] {
                 YamlMap::read(file, {.known = {"gate", "chart"}, .needed = {}});
               }),
               {"a.yaml:1: key 'key_0': is unknown"});
}

TEST(Yaml, ManyNodesAreRejected) {
  const auto file = test::scratch() / "a.yaml";
  test::spill(file, "list: [" + std::string(10'000, ',') + "]\n");
  const Variable variable("CHASLES_READ_MEMORY", "1M");
  expect_parts(input_error([&] { YamlMap::read(file, {.known = {}, .needed = {}}); }),
               {"a.yaml: has 10009 bytes of YAML", "CHASLES_READ_MEMORY"});
}

TEST(Yaml, NestingIsRejected) {
  const auto file = test::scratch() / "a.yaml";
  const BombStopwatch quick;
  for (const std::string& open : {std::string("["), std::string("{a: "), std::string("- ")}) {
    std::string text = open == "- " ? "" : "a: ";
    for (int i = 0; i < 100'000; ++i) text += open;
    test::spill(file, text);
    expect_parts(input_error([&] { YamlMap::read(file, {.known = {}, .needed = {}}); }),
                 {"a.yaml"});
  }
}

TEST(Mat, AStructThatClaimsMoreFieldsThanItsBytesIsRejected) {
  const auto file = test::scratch() / "a.mat";
  const BombStopwatch quick;
  for (const std::string& array :
       {test::mat_struct_claiming(0x7ffffff8), test::mat_struct_beside(0x7ffffff8)}) {
    const std::string bomb = test::mat_file(array);
    EXPECT_LE(bomb.size(), 208u);
    test::spill(file, bomb);
    expect_parts(input_error([&] { read_mat_recording(file); }),
                 {"a.mat: the header of the array at byte 128 is not one"});
  }
}

TEST(Mat, CellsInsideEachOtherAreCounted) {
  const auto file = test::scratch() / "a.mat";
  const std::string cells = test::nested_mat_cells(100'000);
  const BombStopwatch quick;
  for (const std::string& bytes : {cells, test::mat_compressed(cells)}) {
    test::spill(file, test::mat_file(bytes));
    expect_parts(input_error([&] { read_mat_recording(file); }),
                 {"a.mat: nests more than 100 values inside each other"});
  }
  test::spill(file, test::mat_file(test::nested_mat_cells(50)));
  expect_parts(input_error([&] { read_mat_recording(file); }), {"a.mat: field 't': is missing"});
}

}  // namespace
}  // namespace chasles
