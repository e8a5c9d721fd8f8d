#include <chrono>
#include <cmath>
#include <csignal>
#include <map>
#include <thread>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli_process.hpp"

// `chasles batch`: many recordings, a verdict on each, whole whatever is killed.
namespace chasles::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// Recordings of tracks, quick to run: "a", "b", ..., by their seeds.
void simulate(const Scratch& folder, int count, const std::string& more = "") {
  for (int i = 0; i < count; ++i) {
    const std::string name(1, static_cast<char>('a' + i));
    const Outcome made =
        chasles(folder, "simulate turntable --set revolutions=0.15 --quiet --run " +
                            std::to_string(i) + " -o in/" + name + " " + more);
    ASSERT_EQ(made.code, 0) << made.err;
  }
}

std::vector<Json> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<Json> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(Json::parse(line));
  return lines;
}

// The bytes of all files that two batches must have alike.
std::map<std::string, std::string> bytes_of(const fs::path& batch) {
  std::map<std::string, std::string> bytes;
  for (const auto& entry : fs::recursive_directory_iterator(batch)) {
    const std::string name = entry.path().lexically_relative(batch).string();
    if (!entry.is_regular_file() || name.find("timing") != std::string::npos ||
        name.starts_with(".shard")) {
      continue;
    }
    bytes[name] = slurp(entry.path());
  }
  return bytes;
}

void expect_same_batches(const fs::path& a, const fs::path& b) {
  const auto of_a = bytes_of(a), of_b = bytes_of(b);
  EXPECT_GT(of_a.size(), 10u);
  for (const auto& [name, bytes] : of_a) {
    EXPECT_TRUE(of_b.contains(name)) << name;
    if (of_b.contains(name)) {
      EXPECT_EQ(bytes, of_b.at(name)) << name;
    }
  }
  EXPECT_EQ(of_a.size(), of_b.size());
}

// The turntable is seen from afar: its poses are less certain than those of a room.
const std::string kBatch = "batch --estimator filter --no-check --most-sigma 1 ";

TEST(BatchCommand, GivesEachRecordingAVerdictAndAllAPage) {
  const Scratch folder;
  simulate(folder, 2);
  fs::create_directories(folder / "in/empty");
  const Outcome outcome = chasles(folder, kBatch + "in/a in/b in/empty in/gone.bag -o out");
  EXPECT_EQ(outcome.code, 2) << "the worst is no";
  expect_part(outcome.err, "4 recordings: 2 use, 0 check, 2 no");
  const std::vector<Json> printed = lines_of(outcome.out);
  ASSERT_EQ(printed.size(), 4u);
  for (const Json& line : printed) {
    const bool is_good = line.at("name") == "a" || line.at("name") == "b";
    EXPECT_EQ(line.at("verdict"), is_good ? "use" : "no") << line;
    EXPECT_EQ(line.at("attempts"), 1);
    EXPECT_GE(line.at("seconds_wall"), 0);
    if (is_good) {
      EXPECT_EQ(line.at("bound_m").get<double>(), 4 * line.at("worst_sigma_m").get<double>());
      EXPECT_EQ(line.at("path"), "smoothed");
    } else {
      EXPECT_EQ(line.at("reasons")[0].at("reason"), "unreadable");
    }
  }
  const std::vector<Json> kept = lines_of(slurp(folder / "out/verdicts.jsonl"));
  ASSERT_EQ(kept.size(), 4u);
  EXPECT_EQ(kept[0].at("name"), "a");
  EXPECT_EQ(kept[3].at("name"), "gone");
  const Json summary = Json::parse(slurp(folder / "out/summary.json"));
  EXPECT_EQ(summary.at("verdicts"), (Json{{"use", 2}, {"check", 0}, {"no", 2}}));
  EXPECT_EQ(summary.at("reasons"), (Json{{"unreadable", 2}}));
  expect_part(slurp(folder / "out/page.html"), "\"name\":\"gone\"");
  // A run of the batch is a run as any other.
  EXPECT_EQ(chasles(folder, "run in/a -o alone --quiet").code, 0);
  EXPECT_EQ(slurp(folder / "out/runs/a/states.csv"), slurp(folder / "alone/states.csv"));
}

TEST(BatchCommand, TheVerdictCheckHasAnExitCodeOfItsOwn) {
  const Scratch folder;
  simulate(folder, 1);
  EXPECT_EQ(chasles(folder, "batch --estimator filter --no-check --most-sigma 1 in/a -o a").code,
            0);
  const Outcome outcome = chasles(
      folder, "batch --estimator filter --no-check --most-sigma 1e-6 --most-drift 1e-6 in/a -o b");
  EXPECT_EQ(outcome.code, 5);
  EXPECT_EQ(lines_of(outcome.out)[0].at("reasons")[0].at("reason"), "uncertain");
}

TEST(BatchCommand, RunsBatchEstimationByDefault) {
  const Scratch folder;
  simulate(folder, 1);
  ASSERT_EQ(chasles(folder, "batch --no-check --most-sigma 1 in/a -o out").code, 0);
  ASSERT_EQ(chasles(folder, "run in/a --estimator batch -o alone --quiet").code, 0);
  EXPECT_EQ(slurp(folder / "out/runs/a/states.csv"), slurp(folder / "alone/states.csv"));
}

// Without parallax batch estimation has no landmarks, and the poses are still known to millimetres.
TEST(BatchCommand, TheFilterHasThePosesOfACameraThatHardlyMoves) {
  const Scratch folder;
  std::string path;
  for (int i = 0; i <= 400; ++i) {
    path += fmt::format("{:.2f} {:.6f} 0 1 0 0 0 1\n", 0.01 * i, 0.001 * std::sin(0.01 * i));
  }
  spill(folder / "still.tum", path);
  ASSERT_EQ(chasles(folder, "simulate trajectory --path still.tum --quiet -o still").code, 0);
  const Outcome outcome = chasles(
      folder,
      "batch --no-check --least-coverage 0.5 --most-sigma 1 --set batch.loss=none still -o out");
  EXPECT_EQ(outcome.code, 5) << outcome.err;
  const Json record = lines_of(outcome.out)[0];
  ASSERT_EQ(record.at("reasons").size(), 1u) << record;
  EXPECT_EQ(record.at("reasons")[0].at("reason"), "filter_only");
  EXPECT_LT(record.at("ate_m"), 0.005);
  EXPECT_FALSE(Json::parse(slurp(folder / "out/runs/still/summary.json")).contains("batch"));
}

TEST(BatchCommand, ARecordingWithoutATruthHasAVerdictAndNoErrors) {
  const Scratch folder;
  simulate(folder, 1);
  for (const char* file : {"truth.tum", "true_motion.csv", "landmarks_truth.csv"}) {
    fs::remove(folder / "in/a" / file);
  }
  const Outcome outcome = chasles(folder, kBatch + "in/a -o out");
  EXPECT_EQ(outcome.code, 0) << outcome.out;
  EXPECT_FALSE(lines_of(outcome.out)[0].contains("ate_m"));
}

TEST(BatchCommand, AListHasSettingsOfItsOwn) {
  const Scratch folder;
  simulate(folder, 1);
  spill(folder / "list",
        "in/a\n{\"recording\": \"in/a\", \"name\": \"standard\", "
        "\"set\": {\"chart\": \"standard\"}, \"stop\": 2}\n");
  ASSERT_EQ(chasles(folder, kBatch + "--manifest list -o out").code, 0);
  const Json standard = Json::parse(slurp(folder / "out/runs/standard/summary.json"));
  EXPECT_EQ(standard.at("chart"), "standard");
  EXPECT_LT(standard.at("recorded_seconds"), 2.1);
  EXPECT_EQ(Json::parse(slurp(folder / "out/runs/a/summary.json")).at("chart"), "right-sen3");
}

TEST(BatchCommand, HasTheSameBytesInPartsAndAfterAKill) {
  const Scratch folder;
  simulate(folder, 5);
  ASSERT_EQ(chasles(folder, kBatch + "in/? -o whole --jobs 2").code, 0);
  ASSERT_EQ(chasles(folder, kBatch + "in/? -o parts --shard 2/2 --jobs 1").code, 0);
  EXPECT_FALSE(fs::exists(folder / "parts/page.html"));
  ASSERT_EQ(chasles(folder, kBatch + "in/? -o parts --shard 1/2").code, 0);
  expect_same_batches(folder / "whole", folder / "parts");

  {
    std::vector<std::string> words = {"batch",      "--estimator",  "filter",
                                      "--no-check", "--most-sigma", "1"};
    for (const char* name : {"a", "b", "c", "d", "e"}) {
      words.push_back((folder / "in" / name).string());
    }
    words.insert(words.end(), {"--jobs", "1", "-o", (folder / "killed").string()});
    Process process(folder, words);
    for (int tries = 0; tries < 6000 && !fs::exists(folder / "killed/verdicts/b.json"); ++tries) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    EXPECT_EQ(process.code_after(SIGKILL), -1);
  }
  ASSERT_TRUE(fs::exists(folder / "killed/verdicts/a.json"));
  ASSERT_FALSE(fs::exists(folder / "killed/verdicts/e.json")) << "it was done before the kill";
  const std::string all = folder.string() + "/in/?";  // as `in/?`
  const Outcome again = chasles(folder, kBatch + all + " -o killed");
  expect_error(again, 1, "has a batch already; --resume continues it");
  const Outcome resumed = chasles(folder, kBatch + all + " -o killed --resume --jobs 2");
  ASSERT_EQ(resumed.code, 0) << resumed.err;
  EXPECT_LT(lines_of(resumed.out).size(), 5u) << "what was done is not done again";
  expect_same_batches(folder / "whole", folder / "killed");
}

TEST(BatchCommand, CtrlCKeepsWhatIsDone) {
  const Scratch folder;
  simulate(folder, 4);
  std::vector<std::string> words = {"batch",        "--estimator", "filter", "--no-check",
                                    "--most-sigma", "1",           "--jobs", "1"};
  for (const char* name : {"a", "b", "c", "d"}) words.push_back((folder / "in" / name).string());
  words.insert(words.end(), {"-o", (folder / "out").string()});
  Process process(folder, words);
  for (int tries = 0; tries < 6000 && !fs::exists(folder / "out/verdicts/a.json"); ++tries) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(process.code_after(SIGINT), 130);
  expect_part(process.output(), "recordings are done; --resume continues the batch");
  EXPECT_FALSE(fs::exists(folder / "out/page.html"));
  EXPECT_EQ(chasles(folder, kBatch + folder.string() + "/in/? -o out --resume").code, 0);
}

TEST(BatchCommand, SaysWhatBecameBetterOrWorse) {
  const Scratch folder;
  simulate(folder, 3);
  ASSERT_EQ(chasles(folder, kBatch + "in/? -o before").code, 0);
  const Outcome now = chasles(folder,
                              "batch --estimator filter --no-check --most-sigma 1e-6 --most-drift "
                              "1e-6 in/? -o now --against before");
  EXPECT_EQ(now.code, 5);
  expect_part(now.err, "worse: a (was use, is check)");
  expect_part(now.err, "worst_sigma_m: 1.000 times that of the earlier batch");
  const Json difference = Json::parse(slurp(folder / "now/difference.json"));
  EXPECT_EQ(difference.at("worse").size(), 3u);
  expect_error(chasles(folder, kBatch + "in/a -o x --against in"), 2, "verdicts.jsonl");
}

TEST(BatchCommand, RejectsWhatNoRecordingCanUse) {
  const Scratch folder;
  simulate(folder, 2);
  expect_error(chasles(folder, "batch -o x"), 1, "found no recording");
  expect_error(chasles(folder, "batch in/a"), 1, "--output is required");
  expect_error(chasles(folder, kBatch + "in/a in/a -o x"), 1, "in/a: found twice");
  expect_error(chasles(folder, kBatch + "in/a -o x --set gaet=1"), 1, "unknown key 'gaet'");
  expect_error(chasles(folder, kBatch + "in/a -o x --jobs -1"), 1, "--jobs: found -1");
  expect_error(chasles(folder, kBatch + "in/a -o x --shard 3/2"), 1, "--shard: found '3/2'");
  expect_error(chasles(folder, kBatch + "in/a -o x --map-from in/b --shard 1/2"), 1,
               "--map-from excludes --shard");
  ASSERT_EQ(chasles(folder, kBatch + "in/a -o x").code, 0);
  expect_error(chasles(folder, "batch --estimator filter --no-check in/a -o x --resume"), 1,
               "another plan (limits");
  spill(folder / "list", "{\"recording\": \"in/a\", \"stop\": 2}\n");
  expect_error(chasles(folder, kBatch + "--manifest list -o x --resume"), 1,
               "was made with the options {}, and the list says {\"stop\":2.0}");
  expect_error(chasles(folder, kBatch + "in/a -o in/a"), 1, "in/a");
  expect_error(chasles(folder, kBatch + "in/a -o y --map list"), 2, "list");
  expect_error(chasles(folder, kBatch + "in/a -o y --jobs 0"), 1, "--jobs: found 0");
  expect_error(chasles(folder, kBatch + "in/a -o y --start 3 --stop 2"), 1, "--stop: found 2");
  expect_error(chasles(folder, kBatch + "in/a -o y --retry nothing"), 1,
               "unknown reason 'nothing'");
  EXPECT_FALSE(fs::exists(folder / "y/plan.json"));
  fs::rename(folder / "in/b", folder / "a");
  expect_error(chasles(folder, kBatch + "a -o x --resume"), 1, "has the same name");
  spill(folder / "x/verdicts/a.json", "{");
  expect_error(chasles(folder, kBatch + "in/a -o x --resume"), 2, "found no record");
}

TEST(BatchCommand, CollectsWhatRanElsewhere) {
  const Scratch folder;
  simulate(folder, 2);
  ASSERT_EQ(chasles(folder, kBatch + "in/? -o out --shard 1/2").code, 0);
  const Outcome partial = chasles(folder, kBatch + "in/? -o out --collect");
  EXPECT_EQ(partial.code, 3);
  ASSERT_EQ(lines_of(partial.out).size(), 2u);
  EXPECT_EQ(lines_of(partial.out)[0].at("verdict"), "use");
  EXPECT_TRUE(lines_of(partial.out)[1].at("verdict").is_null());
  ASSERT_EQ(chasles(folder, kBatch + "in/? -o out --shard 2/2").code, 0);
  fs::remove(folder / "out/page.html");
  EXPECT_EQ(chasles(folder, kBatch + "in/? -o out --collect").code, 0);
  EXPECT_TRUE(fs::exists(folder / "out/page.html"));
}

// A disk that was away, or a recording that was mended.
TEST(BatchCommand, RunsAgainWhatHasAReason) {
  const Scratch folder;
  simulate(folder, 2);
  fs::rename(folder / "in/b", folder / "b");
  ASSERT_EQ(chasles(folder, kBatch + "in/a in/b -o out").code, 2);
  fs::rename(folder / "b", folder / "in/b");
  ASSERT_EQ(chasles(folder, kBatch + "in/a in/b -o out --resume").code, 2);
  const Outcome again = chasles(folder, kBatch + "in/a in/b -o out --resume --retry unreadable");
  EXPECT_EQ(again.code, 0) << again.out;
  ASSERT_EQ(lines_of(again.out).size(), 1u);
  EXPECT_EQ(lines_of(again.out)[0].at("name"), "b");
}

// A rendered walk is the map of another one.
TEST(BatchCommand, AllPosesAreInTheMapOfTheFirstRecording) {
  const Scratch folder;
  for (const char* run : {"1", "2"}) {
    const Outcome made =
        chasles(folder, std::string("simulate walk --images --quiet --set walk_duration=5 --set "
                                    "rest_duration=1 --set frame_rate=15 --run ") +
                            run + " -o walk" + run);
    ASSERT_EQ(made.code, 0) << made.err;
  }
  const Outcome outcome = chasles(folder,
                                  "batch walk2 walk1 --map-from walk1 --no-check --most-sigma 1 "
                                  "--least-coverage 0.5 -o out");
  ASSERT_EQ(outcome.code, 0) << outcome.out << outcome.err;
  const std::vector<Json> records = lines_of(outcome.out);
  ASSERT_EQ(records.size(), 2u);
  EXPECT_EQ(records[0].at("name"), "walk1");
  EXPECT_EQ(records[1].at("path"), "in_map");
  EXPECT_TRUE(fs::exists(folder / "out/runs/walk2/trajectory_in_map.tum"));
}

}  // namespace
}  // namespace chasles::test
