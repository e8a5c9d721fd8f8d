#pragma once

#include <cstddef>
#include <string>

#include <chasles/base/time.hpp>

namespace chasles::bridge {

/// Of one topic: a header.stamp of 0 is none. Such messages are counted, and the first is reported.
class StampCheck {
 public:
  bool is_set(Time stamp, const std::string& topic);
  std::size_t unset() const { return unset_; }  ///< messages

 private:
  std::size_t unset_ = 0;
};

}  // namespace chasles::bridge
