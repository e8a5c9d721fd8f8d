#pragma once

#include <span>

#include <chasles/camera/camera.hpp>
#include <chasles/estimate/estimate.hpp>
#include <chasles/run_folder/run.hpp>

namespace chasles::app {

/// The row of states.csv for an estimate, without times of processing. `cameras` as calibrated.
RunState run_state(const Estimate& e, std::span<const Camera> cameras);

}  // namespace chasles::app
