#pragma once

#include <cstdint>
#include <vector>

#include <chasles/data/recording.hpp>
#include <chasles/lab/loops_settings.hpp>
#include <chasles/lab/trial.hpp>

namespace chasles {

/// The true poses world_T_imu at the steps 0 ... steps, a second apart, from 0 on.
Trajectory loops_truth(const LoopsSettings& settings);

/// The points that there are to see.
std::vector<TrueLandmark> loops_landmarks(const LoopsSettings& settings);

/// One run of the scene, whose published NEES are an outside check of the error charts: the filter
/// starts at the truth with no uncertainty. Of the variant's settings only `chart` and
/// `first_estimates` count. Position error, attitude error and NEES at every step; the noise of a
/// run is the same for every filter.
Trial run_loops(const LoopsSettings& settings, const FilterVariant& filter, std::uint64_t run);

}  // namespace chasles
