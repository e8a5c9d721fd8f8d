#include <cstdlib>
#include <filesystem>
#include <string>
#include <unistd.h>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chasles/codec/text_file.hpp>
#include <chasles/report/study_testing.hpp>

namespace chasles {
namespace {

using test::synthetic_study;

/// Opens the page in headless Chromium and uses it (src/web/tests/study_page.mjs). With
/// CHASLES_PAGES set the pages and their pictures stay in that folder.
void expect_works_in_a_browser(const std::vector<Study>& studies, const std::string& name) {
  const char* kept = std::getenv("CHASLES_PAGES");
  const auto folder = kept ? std::filesystem::path(kept)
                           : std::filesystem::temp_directory_path() /
                                 ("chasles_study_page_" + std::to_string(getpid()));
  make_folder(folder);
  const auto page = folder / (name + ".html");
  write_file(page, study_page(studies));
  const std::string command = "'" CHASLES_NODE "' '" CHASLES_SOURCE_DIR
                              "/src/web/tests/study_page.mjs' '" +
                              page.string() + "' '" + (folder / name).string() + "'";
  const int status = std::system(command.c_str());
  if (!kept) std::filesystem::remove_all(folder);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 77) GTEST_SKIP() << "skipped: no Chromium";
  EXPECT_EQ(status, 0);
}

TEST(StudyInABrowser, OneRunIsDrawnAndAnswers) {
  expect_works_in_a_browser({synthetic_study()}, "study-run");
}

TEST(StudyInABrowser, ManyFiltersOverManyRunsWithHostileNames) {
  const std::string hostile =
      "</script><script>window.hostile=1</script><img src=x onerror=alert(1)> & \"q\" " +
      std::string(200, 'w');
  expect_works_in_a_browser(
      {synthetic_study({.filters = 11, .runs = 40, .name = hostile, .filter_name = hostile}),
       synthetic_study({.frames = 100})},
      "study-runs");
}

// Their numbers, titles and views are those of Kleinert & Stilla's tables and figures.
TEST(StudyInABrowser, ScenesOfThePaperAreShownAsThere) {
  std::vector<Study> studies;
  for (const char* geometry : {"turntable", "hallway"}) {
    Study study = synthetic_study({.name = geometry});
    auto summary = nlohmann::ordered_json::parse(study.summary);
    summary["scene"]["geometry"] = geometry;
    study.summary = summary.dump();
    studies.push_back(std::move(study));
  }
  expect_works_in_a_browser(studies, "study-paper");
}

// One frame, no truth, no scene, nothing finite.
TEST(StudyInABrowser, WhatIsAbsentLeavesAPage) {
  Study bare = synthetic_study({.filters = 1, .frames = 1});
  bare.truth.clear();
  bare.landmarks.clear();
  bare.filters[0].estimate.clear();
  bare.summary = R"({"filters": [{"filter": "filter-0", "diverged": 1, "runs": 1}]})";
  expect_works_in_a_browser({bare}, "study-bare");
}

}  // namespace
}  // namespace chasles
