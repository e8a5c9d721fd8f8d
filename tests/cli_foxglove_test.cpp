#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <sstream>
#include <vector>

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <chasles/base/opencv_codecs_testing.hpp>
#include <chasles/live/testing.hpp>

#include "cli_process.hpp"
#include "cli_test.hpp"

// `chasles run --foxglove`.
namespace chasles::test {
namespace {

namespace fs = std::filesystem;

std::map<std::string, std::string> files_but_timing(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_regular_file() && !name.starts_with("timing")) files[name] = slurp(entry.path());
  }
  return files;
}

/// The picture is the recording's, at most 640 px wide, except for what a JPEG loses.
void expect_picture(const cv::Mat& picture, const fs::path& recorded) {
  const cv::Mat image = opencv_read(recorded, cv::IMREAD_GRAYSCALE);
  ASSERT_FALSE(image.empty()) << recorded;
  ASSERT_EQ(picture.cols, std::min(image.cols, 640));
  ASSERT_NEAR(picture.rows, static_cast<double>(image.rows) * picture.cols / image.cols, 1);
  cv::Mat small;
  cv::resize(image, small, picture.size(), 0, 0, cv::INTER_AREA);
  EXPECT_LT(cv::norm(picture, small, cv::NORM_L1) / static_cast<double>(small.total()), 6);
}

/// The commands of docs/viewers.md, without the name of the program: those of its blocks of shell.
/// Any free port, because another program may have the one of the page, and no waiting for real
/// time.
std::vector<std::string> commands_of_the_page() {
  std::istringstream page(slurp(fs::path(CHASLES_SOURCE_DIR) / "docs" / "viewers.md"));
  static const std::string kName = "chasles ";
  std::vector<std::string> commands;
  bool shell = false;
  for (std::string line; std::getline(page, line);) {
    if (line.starts_with("```")) shell = line == "```sh";
    if (!shell || !line.starts_with(kName)) continue;
    line = std::regex_replace(line.substr(kName.size()), std::regex("--foxglove$"), "--foxglove 0");
    commands.push_back(std::regex_replace(line, std::regex(" --realtime\\b"), ""));
  }
  return commands;
}

TEST(Foxglove, TheCommandsOfThePageRunAndClientsSeeTheRunAndChangeNoByteOfIt) {
  const Scratch folder;
  const std::vector<std::string> commands = commands_of_the_page();
  ASSERT_EQ(commands.size(), 4u);
  for (const std::string& command : commands) {
    const Outcome outcome = chasles(folder, command);
    ASSERT_EQ(outcome.code, 0) << command << "\n" << outcome.err;
  }
  for (const char* file : {"run/states.csv", "run.mcap", "run.ply", "page.html"}) {
    EXPECT_TRUE(fs::exists(folder / file)) << file;
  }
  ASSERT_EQ(chasles(folder, "run walk -o alone --quiet").code, 0);
  const std::string command = "'" CHASLES_NODE "' '" CHASLES_SOURCE_DIR
                              "/src/web/tests/foxglove_run.mjs' '" CHASLES_BINARY "' '" +
                              (folder / "walk").string() + "' '" + folder.string() + "'";
  EXPECT_EQ(std::system(command.c_str()), 0);
  EXPECT_GT(files_but_timing(folder / "alone").size(), 5u);
  EXPECT_TRUE(files_but_timing(folder / "alone") == files_but_timing(folder / "seen"));
  const auto report = nlohmann::json::parse(slurp(folder / "report.json"), nullptr, false);
  ASSERT_TRUE(report.is_object());
  expect_picture(
      opencv_read(folder / "last.jpg", cv::IMREAD_GRAYSCALE),
      folder / "walk" / "mav0" / "cam0" / "data" / (report.at("time").get<std::string>() + ".png"));
}

TEST(Foxglove, TheOptionIsChecked) {
  const Scratch folder;
  simulate(folder);
  expect_error(chasles(folder, "run rec --quiet --foxglove 70000"), 1, "--foxglove: found '70000'");
  expect_error(chasles(folder, "run rec --quiet --foxglove x"), 1,
               "--foxglove: found 'x', expected a port");
  const Outcome both = chasles(folder, "run rec --quiet --json --live --foxglove 0");
  EXPECT_EQ(both.code, 0) << both.err;
  expect_part(both.err, "chasles: live: http://127.0.0.1:");
  expect_part(both.err, "chasles: foxglove: ws://127.0.0.1:");
  EXPECT_TRUE(nlohmann::json::accept(both.out));
}

TEST(Foxglove, APortThatIsTakenIsAnErrorBeforeTheRun) {
  const Scratch folder;
  simulate(folder);
  ASSERT_EQ(chasles(folder, "run rec -o out --quiet").code, 0);
  Process view(folder, {"view", (folder / "out").string()});
  const int port = view.port();
  ASSERT_GT(port, 0);
  expect_error(chasles(folder, "run rec -o other --quiet --foxglove " + std::to_string(port)), 1,
               "the Foxglove server cannot listen on 127.0.0.1 port " + std::to_string(port) +
                   ": Address already in use; another port may be free (0: any)");
  EXPECT_FALSE(fs::exists(folder / "other" / "states.csv"));
}

}  // namespace
}  // namespace chasles::test
