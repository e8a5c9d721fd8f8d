#pragma once

#include <stdexcept>
#include <string>

namespace chasles {

/// What a process that ends with an error tells its caller (design: "Exit codes").
enum class ExitCode {
  kOk = 0,
  kUsage = 1,            ///< the command line or a setting is wrong
  kBadInput = 2,         ///< a file is missing, malformed or inconsistent
  kNotInitialised = 3,   ///< the recording never allowed the filter to start
  kDiverged = 4,         ///< the estimate is no longer finite or no longer believable
  kThresholdMissed = 5,  ///< an asked-for threshold was missed
};

/// An error with the exit code that it means. The message names the file or the setting, what was
/// found, what was expected, and what to do.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

/// A setting or a command line that cannot be used.
class UsageError : public Error {
 public:
  explicit UsageError(const std::string& message) : Error(ExitCode::kUsage, message) {}
};

/// A file or a recording that cannot be used.
class InputError : public Error {
 public:
  explicit InputError(const std::string& message) : Error(ExitCode::kBadInput, message) {}
};

}  // namespace chasles
