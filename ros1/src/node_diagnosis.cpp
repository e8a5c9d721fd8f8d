#include "node_diagnosis.hpp"

#include <fmt/format.h>

namespace chasles::ros1 {
namespace {

class Diagnosis {
 public:
  /// The first sentence of the worst level stays.
  void add(bool applies, DiagnosisLevel level, const std::string& sentence) {
    if (!applies || (!result.message.empty() && level <= result.level)) return;
    result.level = level;
    result.message = sentence;
  }
  template <typename Value>
  void value(const std::string& name, const Value& of) {
    result.values.emplace_back(name, fmt::format("{}", of));
  }
  OutDiagnosis result;
};

void judge(const app::RobotReport& now, const app::RobotReport& before, Diagnosis& diagnosis) {
  using enum DiagnosisLevel;
  const Health health = now.last ? now.last->health : Health::kOk;
  diagnosis.add(health == Health::kLost, kError, "lost: the estimate is not valid");
  diagnosis.add(now.samples == before.samples, kWarning, "no samples of the IMU come");
  diagnosis.add(now.images.came == before.images.came, kWarning, "no images come");
  diagnosis.add(!now.why_not_started.empty(), kWarning, now.why_not_started);
  diagnosis.add(health == Health::kDegraded, kWarning,
                "degraded: " + (now.last ? chasles::name(now.last->doubt) : ""));
  diagnosis.add(now.images.dropped > before.images.dropped, kWarning,
                fmt::format("{} frames dropped: the estimator is too slow",
                            now.images.dropped - before.images.dropped));
  diagnosis.add(now.order.incomplete > before.order.incomplete, kWarning,
                "a camera lacks images for some frames");
}

void add_estimate(const Estimate& e, Diagnosis& diagnosis) {
  diagnosis.value("health", chasles::name(e.health));
  diagnosis.value("NIS", e.nis);
  diagnosis.value("NIS degrees of freedom", e.nis_dof);
  diagnosis.value("observations", e.observations);
  diagnosis.value("observations used", e.used);
  diagnosis.value("observations rejected", e.rejected);
  diagnosis.value("landmarks in the state", e.in_state);
  diagnosis.value("landmarks", e.landmarks);
  diagnosis.value("position sigma [m]",
                  e.covariance.diagonal().segment<3>(3).cwiseMax(0).cwiseSqrt().norm());
  diagnosis.value("place in the map", e.in_map ? "found" : "none");
}

void add_counts(const app::RobotReport& now, const NodeCounts& counts, Diagnosis& diagnosis) {
  diagnosis.value("started", now.why_not_started.empty() ? "yes" : "no");
  diagnosis.value("samples", now.samples);
  diagnosis.value("samples late", now.order.late_samples);
  diagnosis.value("samples not finite", now.order.unknown_samples);
  diagnosis.value("frames", now.images.came);
  diagnosis.value("frames taken", now.images.taken);
  diagnosis.value("frames dropped", now.images.dropped);
  diagnosis.value("frames waiting", now.images.waiting);
  diagnosis.value("frames incomplete", now.order.incomplete);
  diagnosis.value("images late", now.order.late_images);
  diagnosis.value("images unpaired", now.order.unpaired);
  diagnosis.value("images not decoded", counts.undecodable);
  diagnosis.value("messages without a stamp", counts.unset);
  diagnosis.value("resets", now.resets);
  diagnosis.value("recoveries", now.recoveries);
  if (now.mean_latency) diagnosis.value("latency mean [ms]", 1e3 * *now.mean_latency);
  if (now.worst_latency) diagnosis.value("latency worst [ms]", 1e3 * *now.worst_latency);
}

}  // namespace

OutDiagnosis diagnosis_of(const app::RobotReport& now, const app::RobotReport& before,
                          const NodeCounts& counts, const NodeCounts& counts_before) {
  using enum DiagnosisLevel;
  Diagnosis diagnosis;
  // Counts of another run: only what holds now.
  judge(now, now.resets == before.resets ? before : app::RobotReport{}, diagnosis);
  diagnosis.add(counts.undecodable > counts_before.undecodable, kWarning,
                "images could not be decoded: see the log");
  diagnosis.add(counts.unset > counts_before.unset, kWarning,
                "messages have a header.stamp of 0: the driver does not set it");
  diagnosis.add(true, kOk, "ok");
  if (now.last) add_estimate(*now.last, diagnosis);
  add_counts(now, counts, diagnosis);
  return diagnosis.result;
}

}  // namespace chasles::ros1
