#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <regex>
#include <unistd.h>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/report/study_testing.hpp>
#include <chasles/report/testing.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::column;
using test::data_of;
using test::synthetic_study;
using test::write_study;

const std::string kHostile =
    "</script><script>window.hostile=1</script><img src=x onerror=alert(1)><!-- & \"q\" 'a' ";

/// An empty folder for the running test alone.
class StudyFolder : public ::testing::Test {
 protected:
  StudyFolder() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    path_ = fs::path(::testing::TempDir()) /
            ("chasles_study_" + std::string(info->name()) + std::to_string(::getpid()));
    fs::remove_all(path_);
  }
  ~StudyFolder() override { fs::remove_all(path_); }

  // The message of the InputError that reading the folder throws; empty without one.
  std::string rejection() const {
    try {
      read_study(path_);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  // As rejection(), after a change to a fresh folder.
  std::string rejection_after(const Study& study,
                              const std::function<void(const fs::path&)>& change) {
    fs::remove_all(path_);
    write_study(study, path_);
    change(path_);
    return rejection();
  }

  fs::path path_;
};

void cut(const fs::path& file, std::size_t bytes) {
  const std::string text = read_file(file);
  write_file(file, text.substr(0, text.size() - bytes));
}

void replace(const fs::path& file, const std::string& what, const std::string& by) {
  std::string text = read_file(file);
  const std::size_t at = text.find(what);
  ASSERT_NE(at, std::string::npos) << what;
  write_file(file, text.replace(at, what.size(), by));
}

void expect_part(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "no \"" << part << "\" in: " << text;
}

TEST_F(StudyFolder, OneRunIsReadAsItWasWritten) {
  const Study written = synthetic_study();
  write_study(written, path_);
  ASSERT_TRUE(is_study(path_));
  const Study read = read_study(path_);
  EXPECT_TRUE(read.single_run);
  ASSERT_EQ(read.filters.size(), 3u);
  EXPECT_EQ(read.filters[2].position_error, written.filters[2].position_error);
  EXPECT_EQ(read.filters[1].nees_attitude, written.filters[1].nees_attitude);
  EXPECT_TRUE(std::isnan(read.filters[0].nees_position[0]));
  EXPECT_EQ(read.truth.size(), written.truth.size());
  EXPECT_EQ(read.landmarks[7].p_world, written.landmarks[7].p_world);
  ASSERT_EQ(read.filters[2].landmarks.size(), written.landmarks.size());
  EXPECT_EQ(read.filters[2].landmarks[7].p_world, written.filters[2].landmarks[7].p_world);
  EXPECT_EQ(read.summary, written.summary);
}

TEST_F(StudyFolder, SeveralRunsAreReadAsTheyWereWritten) {
  const Study written = synthetic_study({.frames = 60, .runs = 12});
  write_study(written, path_);
  ASSERT_TRUE(is_study(path_));
  const Study read = read_study(path_);
  EXPECT_FALSE(read.single_run);
  ASSERT_EQ(read.trials.size(), 36u);
  EXPECT_EQ(read.trials[35].nees_pose, written.trials[35].nees_pose);
  EXPECT_TRUE(read.trials[2].diverged);
  EXPECT_EQ(read.filters[1].nees_pose, written.filters[1].nees_pose);
}

TEST_F(StudyFolder, ARunFolderAndAnEmptyOneAreNone) {
  make_folder(path_);
  EXPECT_FALSE(is_study(path_));
  write_file(path_ / "summary.json", "{\"filters\": []}");
  EXPECT_TRUE(is_study(path_));
  write_file(path_ / "states.csv", "");
  EXPECT_FALSE(is_study(path_));
  EXPECT_FALSE(is_study(path_ / "absent"));
}

TEST_F(StudyFolder, WhatIsMissingOrTruncatedOfOneRunIsNamed) {
  const Study study = synthetic_study({.frames = 20});
  for (const char* file : {"summary.json", "filter-0.csv", "filter-2.tum", "truth.tum"}) {
    expect_part(rejection_after(study, [&](const fs::path& f) { fs::remove(f / file); }), file);
  }
  for (const char* file : {"filter-1.csv", "filter-1_landmarks.csv", "landmarks_truth.csv"}) {
    expect_part(rejection_after(study, [&](const fs::path& f) { cut(f / file, 3); }), file);
  }
  expect_part(rejection_after(study, [](const fs::path& f) { write_file(f / "filter-1.tum", ""); }),
              "filter-1.tum");
  const auto without_last_line = [](const fs::path& file) {
    const std::string text = read_file(file);
    write_file(file, text.substr(0, text.rfind('\n', text.size() - 2) + 1));
  };
  expect_part(
      rejection_after(study, [&](const fs::path& f) { without_last_line(f / "filter-1.tum"); }),
      "found 19 poses, expected 20");
  expect_part(rejection_after(study,
                              [&](const fs::path& f) {
                                without_last_line(f / "filter-1.tum");
                                without_last_line(f / "filter-1.csv");
                              }),
              "found 19 rows, expected 20");
  // A folder of an earlier version has no estimated landmarks.
  for (const char* file : {"landmarks_truth.csv", "filter-1_landmarks.csv"}) {
    EXPECT_EQ(rejection_after(study, [&](const fs::path& f) { fs::remove(f / file); }), "");
  }
}

TEST_F(StudyFolder, WhatIsMissingOrTruncatedOfSeveralRunsIsNamed) {
  const Study study = synthetic_study({.frames = 20, .runs = 5});
  for (const char* file : {"curves.csv", "trials.jsonl"}) {
    expect_part(rejection_after(study, [&](const fs::path& f) { fs::remove(f / file); }), file);
    expect_part(rejection_after(study, [&](const fs::path& f) { cut(f / file, 3); }), file);
  }
  expect_part(rejection_after(study, [](const fs::path& f) { fs::remove(f / "summary.json"); }),
              "not complete");
  expect_part(rejection_after(study,
                              [](const fs::path& f) {
                                const std::string text = read_file(f / "trials.jsonl");
                                write_file(f / "trials.jsonl", text.substr(text.find('\n') + 1));
                              }),
              "found 14 trials, expected 15");
  const auto changed = [&](const char* file, const char* what, const char* by) {
    return rejection_after(study, [&](const fs::path& f) { replace(f / file, what, by); });
  };
  expect_part(changed("trials.jsonl", "filter-1", "other"), "trials.jsonl:2: found the filter");
  expect_part(changed("trials.jsonl", "\"diverged\":false", "\"diverged\":7"), "not a trial");
  expect_part(changed("curves.csv", "filter-1,0", "other,0"), "found the filter 'other'");
  expect_part(changed("curves.csv", "nees_pose", "neespose"), "has no column 'nees_pose'");
  expect_part(changed("summary.json", "\"runs\": 5", "\"runs\": \"x\""), "summary.json");
  expect_part(changed("summary.json", "\"filters\"", "\"fliters\""), "summary.json");
  expect_part(changed("summary.json", "filter-0", "../filter-0"), "expected the name of a file");
  expect_part(changed("summary.json", "{", "["), "is not valid JSON");
}

TEST(StudyPage, HoldsTheNumbers) {
  const Study study = synthetic_study({.frames = 50});
  const auto data = data_of(study_page({study}))["studies"][0];
  EXPECT_EQ(data["single_run"], true);
  ASSERT_EQ(data["filters"].size(), 3u);
  const auto nees = column(data["filters"][1]["nees_pose"]);
  const auto x = column(data["filters"][2]["estimate"]["x"]), true_y = column(data["truth"]["y"]);
  ASSERT_EQ(nees.size(), 50u);
  for (std::size_t i = 0; i < 50; ++i) {
    EXPECT_NEAR(nees[i], study.filters[1].nees_pose[i], 1e-4);
    EXPECT_NEAR(x[i] + data["origin"][0].get<double>(), study.filters[2].estimate[i].pose.p.x(),
                1e-4);
    EXPECT_NEAR(true_y[i] + data["origin"][1].get<double>(), study.truth[i].pose.p.y(), 1e-4);
  }
  EXPECT_EQ(column(data["landmarks"]["z"]).size(), 50u);
}

TEST(StudyPage, AFilterThatEndedSoonerHasGapsBehindItsEnd) {
  Study study = synthetic_study({.frames = 30});
  for (auto* values : {&study.filters[1].seconds, &study.filters[1].nees_pose}) values->resize(10);
  study.filters[1].estimate.resize(10);
  const auto data = data_of(study_page({study}))["studies"][0];
  EXPECT_EQ(column(data["seconds"]).size(), 30u);
  const auto nees = column(data["filters"][1]["nees_pose"]);
  ASSERT_EQ(nees.size(), 30u);
  EXPECT_TRUE(std::isfinite(nees[9]));
  EXPECT_TRUE(std::isnan(nees[10]));
  EXPECT_TRUE(std::isnan(column(data["filters"][1]["estimate"]["x"])[29]));
}

// Tables of the chi-square distribution: 300 degrees of freedom have 253.912 and 349.874.
TEST(StudyPage, TheBandsAreThoseOfTheRunsThatCount) {
  const auto one = data_of(study_page({synthetic_study()}))["studies"][0]["bands"];
  EXPECT_EQ(one["runs"], 1);
  EXPECT_NEAR(one["chi2_3_low"].get<double>(), 0.2158, 1e-4);
  EXPECT_NEAR(one["chi2_6_high"].get<double>(), 14.4494, 1e-4);
  Study study = synthetic_study({.frames = 5, .runs = 101});
  const auto hundred = [&] { return data_of(study_page({study}))["studies"][0]["bands"]; };
  EXPECT_EQ(hundred()["runs"], 101);
  for (StudyTrial& trial : study.trials) trial.diverged = trial.diverged || trial.run == 7;
  EXPECT_EQ(hundred()["runs"], 100);
  EXPECT_NEAR(hundred()["chi2_3_low"].get<double>(), 2.53912, 1e-4);
  EXPECT_NEAR(hundred()["chi2_3_high"].get<double>(), 3.49874, 1e-4);
}

TEST(StudyPage, HostileNamesStayText) {
  const auto count = [](const std::string& text, const std::string& what) {
    std::size_t n = 0;
    for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
    return n;
  };
  const std::string benign = study_page({synthetic_study({.frames = 5})});
  Study study = synthetic_study({.frames = 5, .name = kHostile, .filter_name = kHostile});
  study.folder = kHostile;
  const std::string page = study_page({study});
  for (const char* what : {"<script", "</script", "<img", "<!--"}) {
    EXPECT_EQ(count(page, what), count(benign, what)) << what;
  }
  const auto data = data_of(page)["studies"][0];
  EXPECT_EQ(data["summary"]["name"], kHostile);
  EXPECT_EQ(data["filters"][0]["name"], kHostile + "-0");
}

TEST(StudyPage, TheSameStudiesGiveTheSameBytesAndLoadNothing) {
  const std::string page = study_page({synthetic_study(), synthetic_study({.runs = 4})});
  EXPECT_EQ(page, study_page({synthetic_study(), synthetic_study({.runs = 4})}));
  EXPECT_FALSE(
      std::regex_search(page, std::regex("<(link|img|iframe)|<script[^>]* src|@import|url\\(")));
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
  EXPECT_EQ(page.find("@PAGE_"), std::string::npos);
  EXPECT_THROW(study_page({}), UsageError);
}

}  // namespace
}  // namespace chasles
