#include "robot_diagnosis.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace chasles::app {
namespace {

/// A second later than `before`.
RobotReport running(const RobotReport& before = {}) {
  RobotReport report = before;
  report.last = Estimate{};
  report.samples += 200;
  report.images.came += 20;
  report.images.taken += 20;
  return report;
}

std::string value_of(const RobotDiagnosis& diagnosis, const std::string& name) {
  for (const auto& [key, value] : diagnosis.values) {
    if (key == name) return value;
  }
  return "none";
}

TEST(RobotDiagnosis, OfAHealthyRunIsOk) {
  RobotReport now = running();
  now.last->nis = 7.5;
  now.mean_latency = 0.004;
  const RobotDiagnosis diagnosis = diagnose(now, {});
  EXPECT_EQ(diagnosis.level, RobotDiagnosis::kOk);
  EXPECT_EQ(diagnosis.message, "ok");
  EXPECT_EQ(value_of(diagnosis, "NIS"), "7.5");
  EXPECT_EQ(value_of(diagnosis, "latency mean [ms]"), "4");
  EXPECT_EQ(value_of(diagnosis, "health"), "ok");
}

TEST(RobotDiagnosis, ASigmaIsANumberThoughAVarianceIsBelowZeroByRounding) {
  RobotReport now = running();
  now.last->covariance = -1e-18 * Matrix15d::Identity();
  EXPECT_EQ(value_of(diagnose(now, {}), "position sigma [m]"), "0");
}

TEST(RobotDiagnosis, WarnsOfWhatIsMissing) {
  const RobotReport before = running(), now = running(before);
  const auto message_of = [&](const RobotReport& report) {
    const RobotDiagnosis diagnosis = diagnose(report, before);
    EXPECT_EQ(diagnosis.level, RobotDiagnosis::kWarning);
    return diagnosis.message;
  };
  RobotReport silent = now;
  silent.samples = before.samples;
  EXPECT_EQ(message_of(silent), "no samples of the IMU come");
  RobotReport blind = now;
  blind.images.came = before.images.came;
  EXPECT_EQ(message_of(blind), "no images come");
  RobotReport waiting = now;
  waiting.why_not_started = "not initialised after 3 s";
  EXPECT_EQ(message_of(waiting), "not initialised after 3 s");
  RobotReport slow = now;
  slow.images.dropped += 3;
  EXPECT_EQ(message_of(slow), "3 frames dropped: the estimator is too slow");
  RobotReport one_eyed = now;
  one_eyed.order.incomplete += 1;
  EXPECT_EQ(message_of(one_eyed), "a camera lacks images for some frames");
  RobotReport degraded = now;
  degraded.last->health = Health::kDegraded;
  degraded.last->degradation = Degradation::kRejections;
  EXPECT_EQ(message_of(degraded), "degraded: rejections");
  RobotReport leaping = now;
  leaping.wrong_stamps = 1;
  EXPECT_EQ(message_of(leaping), "messages have wrong stamps, far from those before and after");
}

TEST(RobotDiagnosis, ALostEstimateIsAnError) {
  RobotReport now = running();
  now.last->health = Health::kLost;
  now.why_not_started = "anything";
  const RobotDiagnosis diagnosis = diagnose(now, {});
  EXPECT_EQ(diagnosis.level, RobotDiagnosis::kError);
  EXPECT_EQ(diagnosis.message, "lost: the estimate is not valid");
}

// What was dropped before is no news.
TEST(RobotDiagnosis, ComparesWithTheLastOneAndNotAcrossAReset) {
  RobotReport before = running();
  before.images.dropped = 5;
  EXPECT_EQ(diagnose(running(before), before).level, RobotDiagnosis::kOk);
  RobotReport anew = running();
  anew.samples = before.samples;
  anew.images.came = before.images.came;
  anew.resets = 1;
  EXPECT_EQ(diagnose(anew, before).level, RobotDiagnosis::kOk);
}

}  // namespace
}  // namespace chasles::app
