#include <chrono>

#include <chasles/slam/filter_health.hpp>

namespace chasles {
namespace {

constexpr Time kBlind = std::chrono::seconds(1);

bool is_valid(const Estimate& e) {
  const SE3& pose = e.world_T_imu;
  return pose.R.allFinite() && pose.p.allFinite() && e.v_world->allFinite() &&
         e.covariance.allFinite() && !(e.covariance.diagonal().minCoeff() < -1e-9);
}

}  // namespace

// After a second without observations, and for the first second with them again: the drift is
// corrected only when the new observations have determined the velocity.
bool FilterHealth::was_blind(Time time, bool sees) {
  if (!last_seen_) last_seen_ = time;
  const bool blind = time - *last_seen_ > kBlind;
  if (sees) {
    if (blind) regained_ = time;
    last_seen_ = time;
  }
  return blind || (regained_ && time - *regained_ < kBlind);
}

void FilterHealth::assess(Estimate& e, bool sane_clock) {
  if (!sane_clock || !is_valid(e)) {
    e.health = Health::kLost;
    return;
  }
  const int used = e.used + e.tracks.used;
  const bool few = used + e.tracks.waiting < 3;
  const bool starves = !e.zero_velocity && (few || e.rejected + e.tracks.rejected > used);
  starved_ = starves ? starved_ + 1 : 0;
  const bool contradict = recent_innovations_.contradict(e.time, e.nis, e.nis_dof);
  if (was_blind(e.time, !few || e.zero_velocity)) {
    e.degradation = Degradation::kFewObservations;
  } else if (starved_ > 10) {
    e.degradation = few ? Degradation::kFewObservations : Degradation::kRejections;
  } else if (contradict) {
    e.degradation = Degradation::kInnovations;
  }
  if (e.degradation != Degradation::kNone) e.health = Health::kDegraded;
}

}  // namespace chasles
