#pragma once

#include <string>
#include <vector>

namespace chasles {

/// How much a finding matters to a filter.
enum class Severity {
  kNote,     ///< worth knowing
  kWarning,  ///< the estimate will be worse
  kError,    ///< the estimate will be wrong
};

/// "note", "warning" or "error".
const char* severity_name(Severity severity);

/// Something about a recording that is not as it should be.
struct Finding {
  Severity severity = Severity::kNote;
  std::string about = {};  ///< "imu", "images", "cam0", ...
  std::string what = {};   ///< a sentence with the measured number
  double value = 0;        ///< what was measured
  double threshold = 0;    ///< from where on it is a finding
  std::string unit = {};
  std::string advice = {};  ///< what to do
};

/// A number that was measured and is neither good nor bad by itself.
struct Fact {
  std::string about;
  std::string name;
  double value = 0;
  std::string unit = {};
};

/// What a look at a recording gave, in a fixed order.
struct CheckReport {
  std::vector<Fact> facts;
  std::vector<Finding> findings;
  /// Sentences: what could not be looked at, and why.
  std::vector<std::string> not_checked;
};

}  // namespace chasles
