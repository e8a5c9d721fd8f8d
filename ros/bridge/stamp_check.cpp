#include "stamp_check.hpp"

#include <spdlog/spdlog.h>

namespace chasles::bridge {

bool StampCheck::is_set(Time stamp, const std::string& topic) {
  if (stamp != Time::zero()) return true;
  if (unset_++ == 0) {
    spdlog::warn(
        "{}: header.stamp of a message is 0, expected the time of the measurement: such messages "
        "are left out",
        topic);
  }
  return false;
}

}  // namespace chasles::bridge
