#include <chrono>
#include <csignal>
#include <thread>

#include <nlohmann/json.hpp>

#include <chasles/live/testing.hpp>

#include "cli_process.hpp"
#include "cli_test.hpp"

// `chasles view` of a run in progress, and the remains of a killed run.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

/// A real-time run of one minute that has started to write.
struct LongRun {
  explicit LongRun(const Scratch& folder)
      : made(chasles(folder, "simulate hallway -o hallway --quiet").code),
        out((folder / "out").string()),
        process(folder, {"run", (folder / "hallway").string(), "-o", out, "--quiet", "--realtime"},
                "run.log") {}

  /// Whether the estimates so far can be read.
  bool started() const {
    for (int tries = 0; tries < 300; ++tries) {
      if (std::filesystem::exists(out + "/growing/summary.json")) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return false;
  }

  int made;
  std::string out;
  Process process;
};

/// The next text whose progress is at this stage; null if the connection ends before.
Json text_at(Client& client, std::string_view stage) {
  while (const auto frame = client.frame()) {
    if (frame->opcode != 1) continue;
    Json text = Json::parse(frame->text);
    if (text["progress"]["stage"] == stage) return text;
  }
  return nullptr;
}

TEST(Growing, ViewFollowsARunToItsEnd) {
  const Scratch folder;
  LongRun run(folder);
  ASSERT_EQ(run.made, 0);
  ASSERT_TRUE(run.started()) << run.process.output();
  const Outcome second = chasles(folder, "run hallway -o out --quiet");
  EXPECT_EQ(second.code, 1);
  expect_part(second.err, "another run is being written into it");
  expect_error(chasles(folder, "view out out"), 1, "a run is being written into it");

  Process view(folder, {"view", run.out});
  const auto port = static_cast<std::uint16_t>(view.port());
  ASSERT_GT(port, 0) << view.output();
  Client client = viewer(port);
  const Json early = text_at(client, "running");
  ASSERT_FALSE(early.is_null());
  EXPECT_GT(early["rows"], 0);
  EXPECT_FALSE(early["data"]["summary"]["settings"].empty());
  EXPECT_EQ(early["progress"]["stoppable"], false);
  client.say(R"({"stop": true})");  // has no effect
  Json later = text_at(client, "running");
  while (!later.is_null() && later.value("rows", 0) <= early["rows"]) {
    later = text_at(client, "running");
  }
  EXPECT_FALSE(later.is_null()) << "the run grows";

  EXPECT_EQ(run.process.code_after(SIGINT), 130);
  EXPECT_FALSE(std::filesystem::exists(run.out + "/growing"));
  const Json finished = text_at(client, "finished");
  ASSERT_FALSE(finished.is_null());
  EXPECT_FALSE(finished["all"]["runs"][0]["summary"]["frames"].is_null());
  EXPECT_EQ(view.code_after(SIGINT), 0);
}

TEST(Growing, OfAKilledRunThereIsWhatItHadEstimated) {
  const Scratch folder;
  LongRun run(folder);
  ASSERT_EQ(run.made, 0);
  ASSERT_TRUE(run.started()) << run.process.output();
  Process view(folder, {"view", run.out});
  const auto port = static_cast<std::uint16_t>(view.port());
  ASSERT_GT(port, 0) << view.output();
  Client client = viewer(port);
  ASSERT_FALSE(text_at(client, "running").is_null());
  run.process.code_after(SIGKILL);
  const Json failed = text_at(client, "failed");
  ASSERT_FALSE(failed.is_null());
  EXPECT_EQ(failed["progress"]["message"], "the run ended without a result");
  expect_error(chasles(folder, "report out -o page.html"), 2, "out/growing");
  const Outcome report = chasles(folder, "report out/growing -o page.html");
  EXPECT_EQ(report.code, 0) << report.err;
  // The next run replaces it.
  EXPECT_EQ(chasles(folder, "run hallway -o out --quiet").code, 0);
  EXPECT_FALSE(std::filesystem::exists(run.out + "/growing"));
}

}  // namespace
}  // namespace chasles::test
