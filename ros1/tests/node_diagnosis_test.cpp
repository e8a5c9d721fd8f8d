#include "node_diagnosis.hpp"

#include <gtest/gtest.h>

namespace chasles::ros1 {
namespace {

/// A second later than `before`.
app::RobotReport running(const app::RobotReport& before = {}) {
  app::RobotReport report = before;
  report.last = Estimate{};
  report.samples += 200;
  report.images.came += 20;
  report.images.taken += 20;
  return report;
}

std::string value_of(const OutDiagnosis& diagnosis, const std::string& name) {
  for (const auto& [key, value] : diagnosis.values) {
    if (key == name) return value;
  }
  return "none";
}

TEST(Ros1Diagnosis, OfAHealthyRunIsOk) {
  app::RobotReport now = running();
  now.last->nis = 7.5;
  now.mean_latency = 0.004;
  const OutDiagnosis diagnosis = diagnosis_of(now, {}, {}, {});
  EXPECT_EQ(diagnosis.level, DiagnosisLevel::kOk);
  EXPECT_EQ(diagnosis.message, "ok");
  EXPECT_EQ(value_of(diagnosis, "NIS"), "7.5");
  EXPECT_EQ(value_of(diagnosis, "latency mean [ms]"), "4");
  EXPECT_EQ(value_of(diagnosis, "health"), "ok");
}

TEST(Ros1Diagnosis, WarnsOfWhatIsMissing) {
  const app::RobotReport before = running(), now = running(before);
  const auto message_of = [&](const app::RobotReport& report, const NodeCounts& counts = {}) {
    const OutDiagnosis diagnosis = diagnosis_of(report, before, counts, {});
    EXPECT_EQ(diagnosis.level, DiagnosisLevel::kWarning);
    return diagnosis.message;
  };
  app::RobotReport silent = now;
  silent.samples = before.samples;
  EXPECT_EQ(message_of(silent), "no samples of the IMU come");
  app::RobotReport blind = now;
  blind.images.came = before.images.came;
  EXPECT_EQ(message_of(blind), "no images come");
  app::RobotReport waiting = now;
  waiting.why_not_started = "not initialised after 3 s";
  EXPECT_EQ(message_of(waiting), "not initialised after 3 s");
  app::RobotReport slow = now;
  slow.images.dropped += 3;
  EXPECT_EQ(message_of(slow), "3 frames dropped: the estimator is too slow");
  app::RobotReport one_eyed = now;
  one_eyed.order.incomplete += 1;
  EXPECT_EQ(message_of(one_eyed), "a camera lacks images for some frames");
  app::RobotReport doubtful = now;
  doubtful.last->health = Health::kDegraded;
  doubtful.last->doubt = Doubt::kRejections;
  EXPECT_EQ(message_of(doubtful), "degraded: rejections");
  EXPECT_EQ(message_of(now, {.undecodable = 1}), "images could not be decoded: see the log");
  EXPECT_EQ(message_of(now, {.unset = 1}),
            "messages have a header.stamp of 0: the driver does not set it");
}

TEST(Ros1Diagnosis, ALostEstimateIsAnError) {
  app::RobotReport now = running();
  now.last->health = Health::kLost;
  now.why_not_started = "anything";
  const OutDiagnosis diagnosis = diagnosis_of(now, {}, {}, {});
  EXPECT_EQ(diagnosis.level, DiagnosisLevel::kError);
  EXPECT_EQ(diagnosis.message, "lost: the estimate is not valid");
}

// What was dropped before is no news.
TEST(Ros1Diagnosis, ComparesWithTheLastOneAndNotAcrossAReset) {
  app::RobotReport before = running();
  before.images.dropped = 5;
  EXPECT_EQ(diagnosis_of(running(before), before, {}, {}).level, DiagnosisLevel::kOk);
  app::RobotReport anew = running();
  anew.samples = before.samples;
  anew.images.came = before.images.came;
  anew.resets = 1;
  EXPECT_EQ(diagnosis_of(anew, before, {}, {}).level, DiagnosisLevel::kOk);
}

}  // namespace
}  // namespace chasles::ros1
