#include <chasles/robot/joined_imu.hpp>

namespace chasles {
namespace {

void append(const std::vector<ImuSample>& some, std::vector<ImuSample>& all) {
  all.insert(all.end(), some.begin(), some.end());
}

}  // namespace

// Whether a message is of the same time as those of the other topic.
bool JoinedImu::goes_on(Topic& topic, const Topic& other, Time time) {
  if (topic.jumps >= other.jumps) return true;
  if (!topic.behind_since) topic.behind_since = time;
  if (std::chrono::abs(time - *topic.behind_since) <= StampLeaps<AxesSample>::kAhead) {
    ++topic.of_before;
    return false;
  }
  topic.jumps = other.jumps;
  topic.behind_since.reset();
  return true;
}

// The first topic to jump ends what both had.
void JoinedImu::note_jump(Topic& topic, const Topic& other) {
  topic.behind_since.reset();
  const bool first = ++topic.jumps > other.jumps;
  if (first || &topic == &forces_) joiner_.restart_forces();
  if (first || &topic == &rates_) joiner_.restart_rates();
}

std::vector<ImuSample> JoinedImu::add_force(const AxesSample& force) {
  const auto passed = forces_.leaps.add(force);
  if (passed.jumped_back) note_jump(forces_, rates_);
  std::vector<ImuSample> joined;
  for (const AxesSample& one : passed.messages) {
    if (goes_on(forces_, rates_, one.time)) append(joiner_.add_force(one), joined);
  }
  return joined;
}

std::vector<ImuSample> JoinedImu::add_rate(const AxesSample& rate) {
  const auto passed = rates_.leaps.add(rate);
  if (passed.jumped_back) note_jump(rates_, forces_);
  std::vector<ImuSample> joined;
  for (const AxesSample& one : passed.messages) {
    if (goes_on(rates_, forces_, one.time)) append(joiner_.add_rate(one), joined);
  }
  return joined;
}

std::vector<ImuSample> JoinedImu::finish() {
  std::vector<ImuSample> joined;
  if (const auto rate = rates_.leaps.finish()) append(joiner_.add_rate(*rate), joined);
  if (const auto force = forces_.leaps.finish()) append(joiner_.add_force(*force), joined);
  return joined;
}

}  // namespace chasles
