#pragma once

#include <stdexcept>
#include <string>

namespace chasles {

/// Exit codes of a process (design: "Exit codes").
enum class ExitCode {
  kOk = 0,
  kUsage = 1,            ///< the command line or a setting is wrong
  kBadInput = 2,         ///< a file is missing, malformed or inconsistent
  kNotInitialised = 3,   ///< the filter could not be initialised from the recording
  kDiverged = 4,         ///< the estimate is no longer finite or no longer plausible
  kThresholdMissed = 5,  ///< a requested threshold was missed
};

/// An error with its exit code. The message names the file or the setting, the value found, the
/// value expected, and a remedy.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message)
      : std::runtime_error(without_zeros(message)), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  // what() ends at a zero, and a damaged file may have one in what the message quotes.
  static std::string without_zeros(std::string text) {
    for (char& c : text) c = c == '\0' ? '?' : c;
    return text;
  }

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
