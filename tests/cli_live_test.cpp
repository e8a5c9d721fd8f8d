#include <csignal>
#include <map>
#include <vector>

#include <nlohmann/json.hpp>

#include <chasles/live/testing.hpp>

#include "cli_process.hpp"
#include "cli_test.hpp"

// `chasles run --live` and `chasles view`.
namespace chasles::test {
namespace {

std::map<std::string, std::string> files_with_bytes(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    files[entry.path().filename().string()] = slurp(entry.path());
  }
  files.erase("timing.csv");
  files.erase("timing.json");
  return files;
}

TEST(Live, ViewersChangeNoByteOfARun) {
  const Scratch folder;
  simulate(folder, "--set route=RRRRRRRR --set block_length=80 --set block_width=80");
  ASSERT_EQ(chasles(folder, "run rec -o alone --quiet").code, 0);
  const std::string rec = (folder / "rec").string(), seen = (folder / "seen").string();
  Process run(folder, {"run", rec, "-o", seen, "--quiet", "--live"});
  const auto port = static_cast<std::uint16_t>(run.port());
  ASSERT_GT(port, 0);
  std::vector<Client> deaf;  // never read their messages
  for (int i = 0; i < 20; ++i) deaf.push_back(viewer(port, 4096));
  Client reader = viewer(port);
  int texts = 0;
  bool finished = false;
  while (const auto frame = reader.frame()) {
    texts += frame->opcode == 1;
    finished = finished || frame->text.find(R"("stage":"finished")") != std::string::npos;
  }
  EXPECT_EQ(run.code_after(0), 0);
  EXPECT_TRUE(finished);
  EXPECT_GT(texts, 2);
  EXPECT_EQ(files_with_bytes(folder / "alone").size(), 9U);
  EXPECT_TRUE(files_with_bytes(folder / "alone") == files_with_bytes(folder / "seen"));
}

TEST(Live, TheUrlIsNotAmongTheResults) {
  const Scratch folder;
  simulate(folder);
  const Outcome outcome = chasles(folder, "run rec --quiet --json --live");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  expect_part(outcome.err, "chasles: live: http://127.0.0.1:");
  EXPECT_TRUE(nlohmann::json::accept(outcome.out));
}

TEST(Live, TheOptionsAreChecked) {
  const Scratch folder;
  simulate(folder);
  expect_error(chasles(folder, "run rec --quiet --live 70000"), 1, "--live: found '70000'");
  expect_error(chasles(folder, "run rec --quiet --live x"), 1,
               "--live: found 'x', expected a port");
  expect_error(chasles(folder, "run rec --quiet --live-address 0.0.0.0"), 1,
               "--live-address needs --live");
  const Outcome odd = chasles(folder, "run rec --quiet --live --live-address here");
  EXPECT_EQ(odd.code, 1);
  expect_part(odd.err, "found 'here', expected a numeric one");
  const Outcome open = chasles(folder, "run rec --quiet --live --live-address 0.0.0.0");
  EXPECT_EQ(open.code, 0);
  expect_part(open.err, "/?token=");
}

TEST(Live, ViewServesUntilItIsInterrupted) {
  const Scratch folder;
  simulate(folder);
  ASSERT_EQ(chasles(folder, "run rec -o out --quiet").code, 0);
  Process view(folder, {"view", (folder / "out").string()});
  const int port = view.port();
  ASSERT_GT(port, 0);
  const Outcome taken = chasles(folder, "view out --port " + std::to_string(port));
  EXPECT_EQ(taken.code, 1);
  expect_part(taken.err, "another port may be free");
  EXPECT_EQ(view.code_after(SIGINT), 0);
  expect_error(chasles(folder, "view nothing"), 2, "nothing");
  expect_error(chasles(folder, "view out --port x"), 1, "--port: found 'x'");
}

TEST(Live, InABrowserARunArrivesIsLostComesAgainAndIsStopped) {
  const Scratch folder;
  const Outcome made = chasles(folder, "simulate hallway -o hallway --quiet");
  ASSERT_EQ(made.code, 0) << made.err;
  const char* kept = std::getenv("CHASLES_PAGES");
  const std::string pages = kept ? std::string(kept) + "/live" : (folder / "pages").string();
  const std::string command = "'" CHASLES_NODE "' '" CHASLES_SOURCE_DIR
                              "/src/web/tests/live_page.mjs' '" CHASLES_BINARY "' '" +
                              (folder / "hallway").string() + "' '" + pages + "'";
  const int status = std::system(command.c_str());
  if (WIFEXITED(status) && WEXITSTATUS(status) == 77) GTEST_SKIP() << "skipped: no Chromium";
  EXPECT_EQ(status, 0);
}

}  // namespace
}  // namespace chasles::test
