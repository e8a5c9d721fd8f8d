#include <cstdlib>
#include <filesystem>
#include <string>
#include <unistd.h>

#include <gtest/gtest.h>

#include <chasles/report/testing.hpp>

namespace chasles {
namespace {

using test::synthetic_drive;

/// Opens the page in headless Chromium and uses it (tests/page_browser_check.sh). With
/// CHASLES_PAGES set the pages and their pictures stay in that folder.
void expect_works_in_a_browser(const std::vector<ReportRun>& runs, const std::string& name) {
  const char* kept = std::getenv("CHASLES_PAGES");
  const auto folder = kept ? std::filesystem::path(kept)
                           : std::filesystem::temp_directory_path() /
                                 ("chasles_page_test_" + std::to_string(getpid()));
  const auto page = folder / (name + ".html");
  write_page(runs, page);
  const std::string command = "'" CHASLES_SOURCE_DIR "/tests/page_browser_check.sh' '" +
                              page.string() + "' '" + (folder / name).string() + "'";
  const int status = std::system(command.c_str());
  if (!kept) std::filesystem::remove_all(folder);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 77) GTEST_SKIP() << "skipped: no Chromium";
  EXPECT_EQ(status, 0);
}

TEST(PageInABrowser, ADriveIsDrawnAndAnswers) {
  expect_works_in_a_browser({synthetic_drive()}, "drive");
}

TEST(PageInABrowser, SeveralRunsWithHostileNamesAreCompared) {
  ReportRun hostile = synthetic_drive({.states = 300, .landmarks = 200, .seed = 2});
  hostile.run.name =
      "</script><script>window.hostile=1</script><img src=x onerror=alert(1)> & \"q\" " +
      std::string(300, 'w');
  hostile.run.extra_names[0] = "<b>bold</b>";
  ReportRun other = synthetic_drive({.states = 300, .landmarks = 0, .seed = 3, .truth = false});
  other.summary =
      R"({"settings": {"chart": "standard"}, "remarks": ["<i>x</i>"], "health": "lost"})";
  expect_works_in_a_browser({hostile, other}, "several");
}

TEST(PageInABrowser, AbsentTruthDeadReckoningLandmarksAndSummaryLeaveAPage) {
  ReportRun bare =
      synthetic_drive({.states = 200, .landmarks = 0, .truth = false, .dead_reckoning = false});
  bare.summary.clear();
  bare.run.extra_names.clear();
  bare.run.name.clear();
  expect_works_in_a_browser({bare}, "bare");
}

}  // namespace
}  // namespace chasles
