#include "robot_diagnosis.hpp"

namespace chasles::app {
namespace {

// An accelerometer and a gyroscope with a topic each.
void assess_joined(const ImuJoiner::Counts& now, const ImuJoiner::Counts& before,
                   RobotDiagnosis& diagnosis) {
  using enum RobotDiagnosis::Level;
  if (now.forces + now.rates == 0) return;
  diagnosis.add(now.forces == before.forces, kWarning, "no samples of the accelerometer come");
  diagnosis.add(now.rates == before.rates, kWarning, "no samples of the gyroscope come");
  diagnosis.add(now.in_gaps > before.in_gaps, kWarning,
                fmt::format("{} samples of the gyroscope lie between samples of the accelerometer "
                            "that are more than {:.2f} s apart: it is too slow, or pauses",
                            now.in_gaps - before.in_gaps, to_seconds(ImuJoiner::kLongestInterval)));
  const auto dropped = [](const ImuJoiner::Counts& c) {
    return c.dropped_rates + c.dropped_forces;
  };
  diagnosis.add(dropped(now) > dropped(before), kWarning,
                "samples of one sensor of the IMU wait for the other in vain: are both stamped by "
                "one clock?");
}

void assess(const RobotReport& now, const RobotReport& before, RobotDiagnosis& diagnosis) {
  using enum RobotDiagnosis::Level;
  const Health health = now.last ? now.last->health : Health::kOk;
  diagnosis.add(health == Health::kLost, kError, "lost: the estimate is not valid");
  diagnosis.add(now.samples == before.samples, kWarning, "no samples of the IMU come");
  assess_joined(now.joined, before.joined, diagnosis);
  diagnosis.add(now.images.came == before.images.came, kWarning, "no images come");
  diagnosis.add(!now.why_not_started.empty(), kWarning, now.why_not_started);
  diagnosis.add(health == Health::kDegraded, kWarning,
                "degraded: " + (now.last ? name(now.last->degradation) : ""));
  diagnosis.add(now.images.dropped > before.images.dropped, kWarning,
                fmt::format("{} frames dropped: the estimator is too slow",
                            now.images.dropped - before.images.dropped));
  diagnosis.add(now.order.incomplete > before.order.incomplete, kWarning,
                "a camera lacks images for some frames");
  diagnosis.add(now.wrong_stamps > before.wrong_stamps, kWarning,
                "messages have wrong stamps, far from those before and after");
}

void add_estimate(const Estimate& e, RobotDiagnosis& diagnosis) {
  diagnosis.value("health", name(e.health));
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

void add_counts(const RobotReport& now, RobotDiagnosis& diagnosis) {
  diagnosis.value("started", now.why_not_started.empty() ? "yes" : "no");
  diagnosis.value("samples", now.samples);
  diagnosis.value("samples late", now.order.late_samples);
  diagnosis.value("samples not finite", now.order.unknown_samples);
  if (now.joined.forces + now.joined.rates > 0) {
    diagnosis.value("accelerometer samples", now.joined.forces);
    diagnosis.value("gyroscope samples", now.joined.rates);
    diagnosis.value("gyroscope samples not joined",
                    now.joined.without_partner() + now.joined.late_rates +
                        now.joined.unknown_rates + now.joined.dropped_rates);
  }
  diagnosis.value("frames", now.images.came);
  diagnosis.value("frames taken", now.images.taken);
  diagnosis.value("frames dropped", now.images.dropped);
  diagnosis.value("frames waiting", now.images.waiting);
  diagnosis.value("frames incomplete", now.order.incomplete);
  diagnosis.value("images late", now.order.late_images);
  diagnosis.value("images unpaired", now.order.unpaired);
  diagnosis.value("wrong stamps", now.wrong_stamps);
  diagnosis.value("resets", now.resets);
  diagnosis.value("recoveries", now.recoveries);
  if (now.mean_latency) diagnosis.value("latency mean [ms]", 1e3 * *now.mean_latency);
  if (now.worst_latency) diagnosis.value("latency worst [ms]", 1e3 * *now.worst_latency);
}

}  // namespace

RobotDiagnosis diagnose(const RobotReport& now, const RobotReport& before) {
  RobotDiagnosis diagnosis;
  assess(now, now.resets == before.resets ? before : RobotReport{}, diagnosis);
  if (now.last) add_estimate(*now.last, diagnosis);
  add_counts(now, diagnosis);
  return diagnosis;
}

}  // namespace chasles::app
