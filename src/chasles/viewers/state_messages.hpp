#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/report/against_truth.hpp>
#include <chasles/viewers/channels.hpp>

namespace chasles {

/// The messages of /state, chasles.State: the estimate and the statistics of its observations. The
/// run's extra numbers have their own names, in which _ replaces invalid characters.
class StateMessages {
 public:
  /// `extra_names`: Run::extra_names.
  explicit StateMessages(const std::vector<std::string>& extra_names);

  const ProtoMessage& schema() const { return schema_; }
  nlohmann::json message(const RunState& state) const;

 private:
  ProtoMessage schema_;
  std::vector<std::string> values_, sigmas_;  ///< fields of the extra numbers
};

/// The schema of /errors, chasles.Errors: truth minus estimate and NEES.
ProtoMessage errors_schema();
/// A message of it. `error` as AgainstTruth::error.
nlohmann::json errors_message(Time time, const Vector6d& error, const PoseNees& nees);

/// Adds /state, one message per state.
void add_states(const Run& run, Channels& out);

/// Adds /errors, one message per matched state.
void add_errors(const Run& run, const AgainstTruth& errors, Channels& out);

}  // namespace chasles
