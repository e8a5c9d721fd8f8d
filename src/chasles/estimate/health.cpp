#include <chasles/estimate/health.hpp>
#include <chasles/eval/chi2.hpp>

namespace chasles {
namespace {

// A vector and no deque, which asks for memory as it moves on.
template <typename Frame>
void add(const Frame& frame, std::vector<Frame>& last_second) {
  std::erase_if(last_second, [&](const Frame& earlier) {
    return earlier.time < frame.time - std::chrono::seconds(1);
  });
  last_second.push_back(frame);
}

}  // namespace

std::string name(Health health) {
  if (health == Health::kOk) return "ok";
  return health == Health::kDegraded ? "degraded" : "lost";
}

std::string name(Degradation degradation) {
  switch (degradation) {
    case Degradation::kFewObservations:
      return "few_observations";
    case Degradation::kRejections:
      return "rejections";
    case Degradation::kInnovations:
      return "innovations";
    case Degradation::kUnknownSpeed:
      return "unknown_speed";
    case Degradation::kLens:
      return "lens";
    case Degradation::kNone:
      break;
  }
  return "none";
}

bool RecentInnovations::contradict(Time time, double nis, int dof) {
  add({.time = time, .nis = nis, .dof = dof}, last_second_);
  double sum = 0, all = 0;
  for (const Frame& frame : last_second_) {
    sum += frame.nis;
    all += frame.dof;
  }
  return all > 0 && sum > kMostNisPerDof * all && sum > chi2_quantile(0.999, all);
}

Degradation RecentUse::assess(Time time, int used, int rejected, double nis, int dof) {
  add({.time = time, .used = used, .rejected = rejected}, last_second_);
  int all_used = 0;
  int all_rejected = 0;
  for (const Use& use : last_second_) {
    all_used += use.used;
    all_rejected += use.rejected;
  }
  const bool contradict = innovations_.contradict(time, nis, dof);
  if (all_used < 3) return Degradation::kFewObservations;
  if (all_rejected > all_used) return Degradation::kRejections;
  return contradict ? Degradation::kInnovations : Degradation::kNone;
}

}  // namespace chasles
