#include <chasles/slam/health.hpp>

namespace chasles {

std::string name(Health health) {
  if (health == Health::kOk) return "ok";
  return health == Health::kDegraded ? "degraded" : "lost";
}

Health RecentUse::judge(Time time, int used, int rejected) {
  last_second_.push_back({.time = time, .used = used, .rejected = rejected});
  while (last_second_.front().time < time - std::chrono::seconds(1)) last_second_.pop_front();
  int all_used = 0;
  int all_rejected = 0;
  for (const Use& use : last_second_) {
    all_used += use.used;
    all_rejected += use.rejected;
  }
  return all_used < 3 || all_rejected > all_used ? Health::kDegraded : Health::kOk;
}

}  // namespace chasles
