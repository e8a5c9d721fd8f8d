#pragma once

#include <string>
#include <vector>

namespace chasles {

/// The columns of states.csv: fixed first columns (time, pose, standard deviations, covariance),
/// the extra names of the run, their standard deviations as `sigma_NAME`, and fixed last columns
/// (docs/formats.md).
const std::vector<std::string>& state_head_columns();
const std::vector<std::string>& state_tail_columns();
std::vector<std::string> state_columns(const std::vector<std::string>& extra_names);

/// Index of the first column of states.csv with the upper triangle of the pose covariance.
inline constexpr std::size_t kStateCovarianceColumn = 14;

const std::vector<std::string>& landmark_columns();
/// Further ones of a run that knows where its landmarks were initialised; empty for a landmark of
/// which this is not known.
const std::vector<std::string>& initial_columns();
const std::vector<std::string>& prior_map_columns();
/// The columns of timing.csv: time, wall time of the frame, and wall time of each stage as
/// `NAME_ms`.
std::vector<std::string> timing_columns(const std::vector<std::string>& stage_names);

}  // namespace chasles
