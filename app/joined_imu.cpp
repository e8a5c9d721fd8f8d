#include "joined_imu.hpp"

namespace chasles::app {
namespace {

void append(const std::vector<ImuSample>& some, std::vector<ImuSample>& all) {
  all.insert(all.end(), some.begin(), some.end());
}

}  // namespace

std::vector<ImuSample> JoinedImu::add_force(const AxesSample& force) {
  const auto passed = leaps_of_forces_.add(force);
  if (passed.jumped_back) joiner_.restart_forces();
  std::vector<ImuSample> joined;
  for (const AxesSample& one : passed.messages) append(joiner_.add_force(one), joined);
  return joined;
}

std::vector<ImuSample> JoinedImu::add_rate(const AxesSample& rate) {
  const auto passed = leaps_of_rates_.add(rate);
  if (passed.jumped_back) joiner_.restart_rates();
  std::vector<ImuSample> joined;
  for (const AxesSample& one : passed.messages) append(joiner_.add_rate(one), joined);
  return joined;
}

std::vector<ImuSample> JoinedImu::finish() {
  std::vector<ImuSample> joined;
  if (const auto rate = leaps_of_rates_.finish()) append(joiner_.add_rate(*rate), joined);
  if (const auto force = leaps_of_forces_.finish()) append(joiner_.add_force(*force), joined);
  return joined;
}

}  // namespace chasles::app
