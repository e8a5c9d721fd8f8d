#include <algorithm>
#include <map>

#include <chasles/run_folder/run.hpp>
#include <chasles/run_folder/run_columns.hpp>

namespace chasles {

const std::vector<std::string>& state_head_columns() {
  static const std::vector<std::string> columns = [] {
    std::vector<std::string> names{"time_ns",  "x",       "y",       "z",        "qx",
                                   "qy",       "qz",      "qw",      "sigma_rx", "sigma_ry",
                                   "sigma_rz", "sigma_x", "sigma_y", "sigma_z"};
    for (int i = 0; i < 6; ++i) {
      for (int j = i; j < 6; ++j) {
        names.push_back("cov_" + std::to_string(i) + std::to_string(j));
      }
    }
    return names;
  }();
  return columns;
}

const std::vector<std::string>& state_tail_columns() {
  static const std::vector<std::string> columns{"nis",      "nis_dof",   "observations",
                                                "used",     "rejected",  "added",
                                                "in_state", "landmarks", "health"};
  return columns;
}

std::vector<std::string> state_columns(const std::vector<std::string>& extra_names) {
  std::vector<std::string> columns = state_head_columns();
  for (const std::string& name : extra_names) columns.push_back(name);
  for (const std::string& name : extra_names) columns.push_back("sigma_" + name);
  for (const std::string& name : state_tail_columns()) columns.push_back(name);
  return columns;
}

const std::vector<std::string>& landmark_columns() {
  static const std::vector<std::string> columns{
      "landmark", "x",      "y",      "z",     "cov_xx",       "cov_xy",        "cov_xz",
      "cov_yy",   "cov_yz", "cov_zz", "sigma", "observations", "first_seen_ns", "last_seen_ns",
      "in_state"};
  return columns;
}

const std::vector<std::string>& initial_columns() {
  static const std::vector<std::string> columns{
      "initial_x",      "initial_y",      "initial_z",      "initial_cov_xx", "initial_cov_xy",
      "initial_cov_xz", "initial_cov_yy", "initial_cov_yz", "initial_cov_zz"};
  return columns;
}

const std::vector<std::string>& prior_map_columns() {
  static const std::vector<std::string> columns{
      "landmark", "session", "x",      "y",      "z",   "cov_xx",       "cov_xy",
      "cov_xz",   "cov_yy",  "cov_yz", "cov_zz", "own", "observations", "views"};
  return columns;
}

std::vector<std::string> timing_columns(const std::vector<std::string>& stage_names) {
  std::vector<std::string> columns{"time_ns", "ms"};
  for (const std::string& name : stage_names) columns.push_back(name + "_ms");
  return columns;
}

bool is_level(const Run& run) {
  return std::ranges::find(run.extra_names, "accelerometer_bias_x") != run.extra_names.end();
}

std::set<LandmarkId> recognised_landmarks(const Run& run) {
  std::map<LandmarkId, int> of_map;
  if (run.prior_map) {
    for (const SketchPoint& point : run.prior_map->points) of_map[point.id] = point.observations;
  }
  std::set<LandmarkId> recognised;
  for (const RunLandmark& landmark : run.landmarks) {
    const auto before = of_map.find(landmark.id);
    if (before != of_map.end() && landmark.observations > before->second) {
      recognised.insert(landmark.id);
    }
  }
  return recognised;
}

}  // namespace chasles
