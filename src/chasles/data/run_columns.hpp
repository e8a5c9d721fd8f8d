#pragma once

#include <string>
#include <vector>

namespace chasles {

/// The columns of states.csv: a fixed head (time, pose, deviations, covariance), the extra names of
/// the run, their deviations as `sigma_NAME`, and a fixed tail (docs/formats.md).
const std::vector<std::string>& state_head_columns();
const std::vector<std::string>& state_tail_columns();
std::vector<std::string> state_columns(const std::vector<std::string>& extra_names);

/// Where the upper triangle of the pose covariance begins among the columns of states.csv.
inline constexpr std::size_t kStateCovarianceColumn = 14;

const std::vector<std::string>& landmark_columns();
/// The columns of timing.csv: time, wall time of the frame, and each stage's as `NAME_ms`.
std::vector<std::string> timing_columns(const std::vector<std::string>& stage_names);

}  // namespace chasles
