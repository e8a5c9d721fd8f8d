#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/run_folder/folder_replacement.hpp>
#include <chasles/run_folder/run.hpp>
#include <chasles/run_folder/run_columns.hpp>
#include <chasles/run_folder/run_text.hpp>

namespace chasles {
namespace {

std::string header(const std::vector<std::string>& columns) {
  return fmt::format("{}\n", fmt::join(columns, ","));
}

template <typename... Values>
void append(std::string& text, const char* format, const Values&... values) {
  fmt::format_to(std::back_inserter(text), fmt::runtime(format), values...);
}

template <class Pose>
Trajectory trajectory_of(const std::vector<Pose>& poses) {
  Trajectory trajectory;
  for (const Pose& pose : poses) {
    trajectory.push_back({.time = pose.time, .pose = pose.world_T_imu});
  }
  return trajectory;
}

void check_sizes(const Run& run) {
  for (const RunState& state : run.states) {
    if (state.extra.size() == run.extra_names.size() &&
        state.extra_sigma.size() == run.extra_names.size() &&
        state.stages.size() == run.stage_names.size()) {
      continue;
    }
    throw std::invalid_argument(fmt::format(
        "write_run: a state has {} extra numbers, {} sigmas and {} stages, expected {} as "
        "extra_names and {} as stage_names",
        state.extra.size(), state.extra_sigma.size(), state.stages.size(), run.extra_names.size(),
        run.stage_names.size()));
  }
}

// The columns of state_head_columns().
template <class Pose>
void append_pose(std::string& text, const Pose& pose) {
  const Eigen::Vector3d& p = pose.world_T_imu.p;
  const Eigen::Vector4d q = unit_quaternion(pose.world_T_imu.R);
  append(text, "{},{},{},{},{},{},{},{}", pose.time.count(), p.x(), p.y(), p.z(), q[0], q[1], q[2],
         q[3]);
  const Matrix6d& P = pose.pose_covariance;
  // What a start defines, such as the heading, has a variance of 0 but for rounding, on either
  // side.
  for (int i = 0; i < 6; ++i) append(text, ",{}", std::sqrt(std::max(P(i, i), 0.0)));
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) append(text, ",{}", P(i, j));
  }
}

constexpr std::size_t kRowsOfPart = 1000;

// A table, some rows at a time, for write_parts().
template <class Row>
std::function<bool(std::string&)> parts_of_table(
    const std::string& columns, std::span<const Row> rows,
    const std::function<void(std::string&, std::span<const Row>)>& append_some) {
  return [columns, rows, append_some, begins = true](std::string& part) mutable {
    if (!begins && rows.empty()) return false;
    if (std::exchange(begins, false)) part = columns;
    const std::size_t count = std::min(kRowsOfPart, rows.size());
    append_some(part, rows.first(count));
    rows = rows.subspan(count);
    return true;
  };
}

void append_poses(std::string& text, std::span<const SmoothedPose> poses) {
  for (const SmoothedPose& pose : poses) {
    append_pose(text, pose);
    text += '\n';
  }
}

void write_poses(const std::filesystem::path& file, std::span<const SmoothedPose> poses) {
  write_parts(file,
              parts_of_table<SmoothedPose>(header(state_head_columns()), poses, append_poses));
}

void append_rows(std::string& text, std::span<const RunState> states) {
  for (const RunState& s : states) {
    append_pose(text, s);
    for (const double value : s.extra) append(text, ",{}", value);
    for (const double value : s.extra_sigma) append(text, ",{}", value);
    append(text, ",{},{},{},{},{},{},{},{},{}\n", s.nis, s.nis_dof, s.observations, s.used,
           s.rejected, s.added, s.in_state, s.landmarks, s.health);
  }
}

std::string timing_text(const Run& run) {
  std::string text = header(timing_columns(run.stage_names));
  for (const RunState& s : run.states) {
    append(text, "{},{:.4f}", s.time.count(), s.milliseconds);
    for (const double stage : s.stages) append(text, ",{:.4f}", stage);
    text += "\n";
  }
  return text;
}

double distance_sigma(const RunLandmark& landmark) {
  return std::sqrt(landmark.covariance.trace());
}

void append_landmark(std::string& text, const RunLandmark& l, bool initial) {
  const Eigen::Matrix3d& P = l.covariance;
  append(text, "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{:d}", l.id, l.p_world.x(), l.p_world.y(),
         l.p_world.z(), P(0, 0), P(0, 1), P(0, 2), P(1, 1), P(1, 2), P(2, 2), distance_sigma(l),
         l.observations, l.first_seen.count(), l.last_seen.count(), l.in_state);
  if (l.initial) {
    const auto& [p, C] = *l.initial;
    append(text, ",{},{},{},{},{},{},{},{},{}", p.x(), p.y(), p.z(), C(0, 0), C(0, 1), C(0, 2),
           C(1, 1), C(1, 2), C(2, 2));
  } else if (initial) {
    text.append(initial_columns().size(), ',');
  }
  text += '\n';
}

}  // namespace

std::function<bool(std::string&)> state_parts(const Run& run, std::size_t from) {
  return parts_of_table<RunState>(from == 0 ? header(state_columns(run.extra_names)) : "",
                                  std::span(run.states).subspan(from), append_rows);
}

std::function<bool(std::string&)> landmark_parts(std::span<const RunLandmark> landmarks) {
  const bool initial =
      std::ranges::any_of(landmarks, [](const RunLandmark& l) { return l.initial.has_value(); });
  std::vector<std::string> columns = landmark_columns();
  if (initial) columns.insert(columns.end(), initial_columns().begin(), initial_columns().end());
  return parts_of_table<RunLandmark>(
      header(columns), landmarks, [initial](std::string& text, std::span<const RunLandmark> some) {
        for (const RunLandmark& l : some) append_landmark(text, l, initial);
      });
}

namespace {

std::string ply_bytes(const std::vector<RunLandmark>& landmarks) {
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment metres, the frame of trajectory.tum\n"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "property float sigma\nend_header\n",
      landmarks.size());
  for (const RunLandmark& l : landmarks) {
    for (const double value : {l.p_world.x(), l.p_world.y(), l.p_world.z(), distance_sigma(l)}) {
      const auto number = static_cast<float>(value);
      char raw[sizeof(number)];
      std::memcpy(raw, &number, sizeof(number));
      bytes.append(raw, sizeof(number));
    }
  }
  return bytes;
}

std::string prior_map_text(const MapSketch& map) {
  std::string text = header(prior_map_columns());
  for (const SketchPoint& l : map.points) {
    const Eigen::Matrix3d& P = l.covariance;
    append(text, "{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", l.id, l.session, l.p_map.x(),
           l.p_map.y(), l.p_map.z(), P(0, 0), P(0, 1), P(0, 2), P(1, 1), P(1, 2), P(2, 2), l.own,
           l.observations, l.views);
  }
  return text;
}

}  // namespace

nlohmann::ordered_json write_run(const Run& run, const nlohmann::ordered_json& summary,
                                 const std::filesystem::path& folder,
                                 const std::function<std::string()>& timing) {
  check_sizes(run);
  FolderReplacement replacement(folder);
  const std::filesystem::path& place = replacement.place();
  write_tum(trajectory_of(run.states), place / "trajectory.tum");
  write_parts(place / "states.csv", state_parts(run));
  if (!run.smoothed.empty()) {
    write_tum(trajectory_of(run.smoothed), place / "trajectory_smoothed.tum");
    write_poses(place / "smoothed.csv", run.smoothed);
  }
  if (!run.in_map.empty()) {
    write_tum(trajectory_of(run.in_map), place / "trajectory_in_map.tum");
    write_poses(place / "in_map.csv", run.in_map);
  }
  if (run.prior_map) write_file(place / "prior_map.csv", prior_map_text(*run.prior_map));
  write_file(place / "timing.csv", timing_text(run));
  write_parts(place / "landmarks.csv", landmark_parts(run.landmarks));
  write_file(place / "map.ply", ply_bytes(run.landmarks));
  if (!run.truth.empty()) write_tum(run.truth, place / "truth.tum");
  if (!run.dead_reckoning.empty()) write_tum(run.dead_reckoning, place / "dead_reckoning.tum");
  write_plan_of(run.plan, place);
  write_shown_images(run.images, place);
  if (timing) write_file(place / "timing.json", timing());
  return replacement.commit(summary);
}

}  // namespace chasles
