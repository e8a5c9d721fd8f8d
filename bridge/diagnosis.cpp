#include "diagnosis.hpp"

#include <cmath>

#include <fmt/format.h>

#include <chasles/slam/health.hpp>

namespace chasles::bridge {
namespace {

void judge(const app::RobotReport& report, Diagnosis& diagnosis) {
  if (!report.why_not_started.empty()) {
    diagnosis.level = Diagnosis::kWarn;
    diagnosis.message = report.samples == 0 ? "no sample of the IMU has come"
                                            : "not started: " + report.why_not_started;
  } else if (!report.last) {
    diagnosis.level = Diagnosis::kWarn;
    diagnosis.message = "no estimate yet";
  } else if (report.last->health == Health::kOk) {
    diagnosis.message = "ok";
  } else {
    const bool lost = report.last->health == Health::kLost;
    diagnosis.level = lost ? Diagnosis::kError : Diagnosis::kWarn;
    diagnosis.message = lost ? "lost" : "degraded: " + name(report.last->doubt);
  }
}

}  // namespace

Diagnosis diagnose(const app::RobotReport& report) {
  Diagnosis diagnosis;
  judge(report, diagnosis);
  const auto add = [&](const char* key, const auto& value) {
    diagnosis.values.emplace_back(key, fmt::format("{}", value));
  };
  add("samples", report.samples);
  add("frames", report.images.came);
  add("frames dropped", report.images.dropped);
  add("frames waiting", report.images.waiting);
  add("frames incomplete", report.order.incomplete);
  add("images late", report.order.late_images);
  add("samples late", report.order.late_samples);
  add("resets", report.resets);
  add("recoveries", report.recoveries);
  if (report.mean_latency) add("mean latency ms", 1e3 * *report.mean_latency);
  if (report.worst_latency) add("worst latency ms", 1e3 * *report.worst_latency);
  if (report.last) {
    add("landmarks", report.last->landmarks);
    add("sigma of the position m",
        std::sqrt(report.last->covariance.diagonal().segment<3>(3).sum()));
  }
  return diagnosis;
}

}  // namespace chasles::bridge
