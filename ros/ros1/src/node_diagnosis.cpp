#include "node_diagnosis.hpp"

#include "robot_diagnosis.hpp"

namespace chasles::ros1 {

OutDiagnosis diagnosis_of(const app::RobotReport& now, const app::RobotReport& before,
                          const NodeCounts& counts, const NodeCounts& counts_before) {
  using enum app::RobotDiagnosis::Level;
  app::RobotDiagnosis diagnosis = app::diagnose(now, before);
  diagnosis.add(counts.undecodable > counts_before.undecodable, kWarning,
                "images could not be decoded: see the log");
  diagnosis.add(counts.unset > counts_before.unset, kWarning,
                "messages have a header.stamp of 0: the driver does not set it");
  diagnosis.value("images not decoded", counts.undecodable);
  diagnosis.value("messages without a stamp", counts.unset);
  return {.level = static_cast<DiagnosisLevel>(diagnosis.level),
          .message = diagnosis.message,
          .values = diagnosis.values};
}

}  // namespace chasles::ros1
