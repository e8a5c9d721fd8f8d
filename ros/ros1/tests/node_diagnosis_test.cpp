#include "node_diagnosis.hpp"

#include <gtest/gtest.h>

namespace chasles::ros1 {
namespace {

app::RobotReport running() {
  app::RobotReport report;
  report.last = Estimate{};
  report.samples = 200;
  report.images.came = report.images.taken = 20;
  return report;
}

TEST(Ros1Diagnosis, IsThatOfAllNodes) {
  const OutDiagnosis healthy = diagnosis_of(running(), {}, {}, {});
  EXPECT_EQ(healthy.level, DiagnosisLevel::kOk);
  EXPECT_EQ(healthy.message, "ok");
  app::RobotReport lost = running();
  lost.last->health = Health::kLost;
  const OutDiagnosis diagnosis = diagnosis_of(lost, {}, {.undecodable = 1}, {});
  EXPECT_EQ(diagnosis.level, DiagnosisLevel::kError);
  EXPECT_EQ(diagnosis.message, "lost: the estimate is not valid");
}

TEST(Ros1Diagnosis, WarnsOfWhatTheNodeLeavesOut) {
  const auto message_of = [](const NodeCounts& counts) {
    const OutDiagnosis diagnosis = diagnosis_of(running(), {}, counts, {});
    EXPECT_EQ(diagnosis.level, DiagnosisLevel::kWarning);
    return diagnosis.message;
  };
  EXPECT_EQ(message_of({.undecodable = 1}), "images could not be decoded: see the log");
  EXPECT_EQ(message_of({.unset = 1}),
            "messages have a header.stamp of 0: the driver does not set it");
  EXPECT_EQ(diagnosis_of(running(), {}, {.unset = 1}, {.unset = 1}).message, "ok");
}

}  // namespace
}  // namespace chasles::ros1
