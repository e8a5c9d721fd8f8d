#pragma once

#include <string>
#include <vector>

#include <chasles/slam/slam.hpp>

namespace chasles::app {

/// Run::stage_names of a filter.
inline std::vector<std::string> filter_stage_names() {
  return {"propagation", "update", "landmarks"};
}

/// RunState::stages of a filter [ms].
inline std::vector<double> filter_stages(const FilterSeconds& s) {
  return {1e3 * s.propagation, 1e3 * s.update, 1e3 * s.landmarks};
}

}  // namespace chasles::app
