#pragma once

#include <cstdint>
#include <vector>

#include <chasles/lab/loops_settings.hpp>
#include <chasles/lab/trial.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles {

/// The true poses world_T_imu at the steps 0 ... steps, one second apart, from time 0 on.
Trajectory loops_truth(const LoopsSettings& settings);

/// The landmarks of the scene.
std::vector<TrueLandmark> loops_landmarks(const LoopsSettings& settings);

/// One run of the scene. Its published NEES are an external check of the error charts. The filter
/// starts at the truth with zero covariance. Of the variant's settings only `chart` and
/// `first_estimates` have an effect. The trial has position error, attitude error and NEES at every
/// step; all filters get the same noise in a run.
Trial run_loops(const LoopsSettings& settings, const FilterVariant& filter, std::uint64_t run,
                KeepMap keep_map = KeepMap::kNo);

}  // namespace chasles
