#pragma once

#include <chasles/recording/recording.hpp>

namespace chasles {

/// Prints the reader's remarks to stderr if an exception ends the scope: they may hold its cause.
/// The error itself stays the last line. Also with --quiet.
class RemarksOnError {
 public:
  /// The recording must outlive the object, and may change.
  explicit RemarksOnError(const Recording& recording);
  RemarksOnError(const RemarksOnError&) = delete;
  RemarksOnError& operator=(const RemarksOnError&) = delete;
  ~RemarksOnError();

 private:
  const Recording& recording_;
  int exceptions_;  // in flight before
};

}  // namespace chasles
