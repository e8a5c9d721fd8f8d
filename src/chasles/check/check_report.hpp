#pragma once

#include <string>
#include <vector>

namespace chasles {

/// The effect of a finding on a filter.
enum class Severity {
  kNote,     ///< for information
  kWarning,  ///< the estimate will be less accurate
  kError,    ///< the estimate will be wrong
};

/// "note", "warning" or "error".
const char* severity_name(Severity severity);

/// A deficiency of a recording.
struct Finding {
  Severity severity = Severity::kNote;
  std::string about = {};  ///< "imu", "images", "cam0", ...
  std::string what = {};   ///< one sentence with the measured value
  double value = 0;        ///< the measured value
  double threshold = 0;    ///< the limit beyond which it is a finding
  std::string unit = {};
  std::string advice = {};  ///< recommended action
};

/// A measured value that is neither good nor bad by itself.
struct Fact {
  std::string about;
  std::string name;
  double value = 0;
  std::string unit = {};
};

/// The results of check_recording(), in a fixed order.
struct CheckReport {
  std::vector<Fact> facts;
  std::vector<Finding> findings;
  /// One sentence for each check that was not possible, with the reason.
  std::vector<std::string> not_checked;
};

}  // namespace chasles
