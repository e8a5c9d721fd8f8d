#include <regex>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/report/report.hpp>
#include <chasles/report/testing.hpp>

namespace chasles {
namespace {

using test::data_of;
using test::synthetic_drive;

ReportRun reported_drive() { return synthetic_drive({.states = 50, .landmarks = 40}); }

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

TEST(Report, HostileNamesStayText) {
  const std::string hostile =
      "</script><script>window.hostile=1</script><img src=x onerror=alert(1)>"
      "<!-- & \"quotes\" 'and' \\ \xe2\x80\xa8 " +
      std::string(5000, 'w');
  ReportRun drive = reported_drive();
  const std::string benign_page = run_page({drive});
  drive.run.name = hostile;
  drive.run.extra_names[0] = hostile;
  drive.run.states[3].health = hostile;
  drive.summary = nlohmann::json{{"remarks", {hostile}}, {hostile, hostile}}.dump();
  const std::string page = run_page({drive});
  for (const char* what : {"<script", "</script", "<img", "<!--"}) {
    EXPECT_EQ(count(page, what), count(benign_page, what)) << what;
  }
  const nlohmann::json run = data_of(page)["runs"][0];
  EXPECT_EQ(run["name"], hostile);
  EXPECT_EQ(run["summary"]["remarks"][0], hostile);
  EXPECT_EQ(run["health_names"][1], hostile);
}

TEST(Report, TheSameRunsGiveTheSameBytes) {
  EXPECT_EQ(run_page({reported_drive(), reported_drive()}),
            run_page({reported_drive(), reported_drive()}));
}

TEST(Report, TheLivePageMayAskItsOwnServerAndNothingElse) {
  const std::string page = live_page();
  EXPECT_EQ(count(page, "content=\"default-src 'none'; connect-src 'self'; script-src"), 1U);
  EXPECT_EQ(data_of(page), nlohmann::json({{"live", true}}));
  EXPECT_EQ(count(run_page({reported_drive()}), "connect-src"), 0U);
}

TEST(Report, LoadsNothing) {
  const std::string page = run_page({reported_drive()});
  // Libraries contain addresses in their messages; only elements or styles can load something.
  EXPECT_FALSE(
      std::regex_search(page, std::regex("<(link|img|iframe)|<script[^>]* src|@import|url\\(")));
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
  EXPECT_EQ(page.find("@PAGE_"), std::string::npos);
}

TEST(Report, AThousandFramesAndSevenThousandLandmarksStayBelowOneAndAHalfMegabytes) {
  const ReportRun drive = synthetic_drive({.states = 1100, .landmarks = 7000});
  ASSERT_EQ(drive.run.landmarks.size(), 7000U);
  EXPECT_LT(run_page({drive}).size(), 1'500'000U);
}

// 20 frames a second.
TEST(Report, TenMinutesStayBelowFifteenMegabytes) {
  const ReportRun drive = synthetic_drive({.states = 12000, .landmarks = 20000});
  ASSERT_EQ(drive.run.states.size(), 12000U);
  const std::size_t size = run_page({drive}).size();
  RecordProperty("bytes", std::to_string(size));
  EXPECT_LT(size, 15'000'000U);
}

TEST(Report, SaysWhatIsWrongWithItsInput) {
  EXPECT_THROW(run_page({}), UsageError);
  ReportRun drive = reported_drive();
  drive.summary = "[1, 2";
  EXPECT_THROW(run_page({drive}), InputError);
}

}  // namespace
}  // namespace chasles
