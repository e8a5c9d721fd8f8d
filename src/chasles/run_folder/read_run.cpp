#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/codec/csv.hpp>
#include <chasles/codec/folder_names.hpp>
#include <chasles/codec/json_text.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/run_folder/folder_replacement.hpp>
#include <chasles/run_folder/growing_run.hpp>
#include <chasles/run_folder/run.hpp>
#include <chasles/run_folder/run_columns.hpp>

namespace chasles {
namespace {

// The names between the fixed first and last columns of states.csv.
std::vector<std::string> extra_names(const CsvReader& csv) {
  const auto& columns = csv.columns();
  const std::size_t fixed = state_head_columns().size() + state_tail_columns().size();
  std::vector<std::string> names;
  if (columns.size() > fixed) {
    const auto begin = columns.begin() + static_cast<std::ptrdiff_t>(state_head_columns().size());
    names.assign(begin, begin + static_cast<std::ptrdiff_t>((columns.size() - fixed) / 2));
  }
  if (columns == state_columns(names)) return names;
  throw InputError(fmt::format("{}: has the columns {}, expected {}", csv.where(),
                               fmt::join(columns, ","), fmt::join(state_columns(names), ",")));
}

int small_integer(const CsvReader& csv, std::size_t column) {
  const std::int64_t value = csv.integer(column);
  if (std::in_range<int>(value)) return static_cast<int>(value);
  throw InputError(fmt::format("{}: {} is out of range", csv.where(column), value));
}

// The columns of state_head_columns().
template <class Pose>
Pose read_pose(const CsvReader& csv) {
  Pose s;
  s.time = csv.time(0);
  s.world_T_imu.p = {csv.number(1), csv.number(2), csv.number(3)};
  const Eigen::Vector4d q(csv.number(4), csv.number(5), csv.number(6), csv.number(7));
  s.world_T_imu.R = q.allFinite()
                        ? checked_quaternion(csv.where(4), q)
                        : Eigen::Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN());
  std::size_t column = kStateCovarianceColumn;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) {
      s.pose_covariance(i, j) = s.pose_covariance(j, i) = csv.number(column++);
    }
  }
  return s;
}

RunState read_state(const CsvReader& csv, std::size_t extras) {
  auto s = read_pose<RunState>(csv);
  std::size_t column = state_head_columns().size();
  for (std::size_t i = 0; i < extras; ++i) s.extra.push_back(csv.number(column++));
  for (std::size_t i = 0; i < extras; ++i) s.extra_sigma.push_back(csv.number(column++));
  s.nis = csv.number(column++);
  for (int* count :
       {&s.nis_dof, &s.observations, &s.used, &s.rejected, &s.added, &s.in_state, &s.landmarks}) {
    *count = small_integer(csv, column++);
  }
  s.health = csv.text(column);
  return s;
}

// A run in progress appends rows; those that its summary counts are complete.
std::string states_bytes(const std::filesystem::path& file, const nlohmann::ordered_json& summary) {
  std::string bytes = read_file(file);
  const auto whole = summary.find(kStatesBytes);
  if (whole == summary.end()) return bytes;
  if (!whole->is_number_unsigned() || whole->get<std::size_t>() > bytes.size()) {
    throw InputError(fmt::format("{}: has {} bytes, summary.json states {}: the file is truncated",
                                 file.string(), bytes.size(), json_text(*whole)));
  }
  bytes.resize(whole->get<std::size_t>());
  return bytes;
}

void read_states(const std::filesystem::path& file, const nlohmann::ordered_json& summary,
                 Run& run) {
  CsvReader csv(file.string(), states_bytes(file, summary), LastLine::kMustEnd);
  run.extra_names = extra_names(csv);
  while (csv.next()) {
    run.states.push_back(read_state(csv, run.extra_names.size()));
    if (run.states.size() < 2) continue;
    check_rises(csv.where(0), run.states[run.states.size() - 2].time, run.states.back().time);
  }
}

std::vector<SmoothedPose> read_smoothed(const std::filesystem::path& file) {
  std::vector<SmoothedPose> poses;
  if (!std::filesystem::exists(file)) return poses;
  CsvReader csv(file, state_head_columns(), {}, LastLine::kMustEnd);
  while (csv.next()) {
    poses.push_back(read_pose<SmoothedPose>(csv));
    if (poses.size() < 2) continue;
    check_rises(csv.where(0), poses[poses.size() - 2].time, poses.back().time);
  }
  return poses;
}

// The columns of timing.csv after the wall time, without their unit.
std::vector<std::string> stage_names(const CsvReader& csv) {
  std::vector<std::string> names;
  for (std::size_t k = 2; k < csv.columns().size(); ++k) {
    const std::string& column = csv.columns()[k];
    names.push_back(column.substr(0, column.size() - std::min<std::size_t>(column.size(), 3)));
  }
  if (csv.columns() == timing_columns(names)) return names;
  throw InputError(fmt::format("{}: has the columns {}, expected {} and what stages took, NAME_ms",
                               csv.where(), fmt::join(csv.columns(), ","),
                               fmt::join(timing_columns({}), ",")));
}

void read_timing(const std::filesystem::path& file, Run& run) {
  CsvReader csv(file);
  run.stage_names = stage_names(csv);
  for (RunState& state : run.states) {
    if (!csv.next() || csv.integer(0) != state.time.count()) {
      throw InputError(fmt::format("{}: expected the row of {} ns, one for each row of states.csv",
                                   csv.where(), state.time.count()));
    }
    state.milliseconds = csv.number(1);
    for (std::size_t k = 0; k < run.stage_names.size(); ++k) {
      state.stages.push_back(csv.number(2 + k));
    }
  }
}

Eigen::Vector3d point_at(const CsvReader& csv, std::size_t column) {
  return {csv.number(column), csv.number(column + 1), csv.number(column + 2)};
}

// Of the columns xx, xy, xz, yy, yz, zz.
Eigen::Matrix3d symmetric_at(const CsvReader& csv, std::size_t column) {
  const double xy = csv.number(column + 1), xz = csv.number(column + 2),
               yz = csv.number(column + 4);
  Eigen::Matrix3d P;
  P << csv.number(column), xy, xz, xy, csv.number(column + 3), yz, xz, yz, csv.number(column + 5);
  return P;
}

std::vector<RunLandmark> read_landmarks(const std::filesystem::path& file) {
  CsvReader csv(file, landmark_columns(), initial_columns(), LastLine::kMustEnd);
  const std::size_t first = landmark_columns().size();
  const bool initial = csv.columns().size() > first;
  std::vector<RunLandmark> landmarks;
  while (csv.next()) {
    RunLandmark& l = landmarks.emplace_back();
    l.id = csv.integer(0);
    l.p_world = point_at(csv, 1);
    l.covariance = symmetric_at(csv, 4);
    l.observations = small_integer(csv, 11);
    l.first_seen = csv.time(12);
    l.last_seen = csv.time(13);
    l.in_state = small_integer(csv, 14) != 0;
    if (!initial || csv.text(first).empty()) continue;
    l.initial.emplace();
    l.initial->p_world = point_at(csv, first);
    l.initial->covariance = symmetric_at(csv, first + 3);
  }
  return landmarks;
}

// `place_in_map` of the summary.
MapSketch place_in_map(const nlohmann::ordered_json& summary, const std::filesystem::path& file) {
  MapSketch map;
  try {
    const nlohmann::ordered_json& place = summary.at("place_in_map");
    const nlohmann::ordered_json& pose = place.at("world_T_map");
    const auto p = pose.at("position_m").get<std::array<double, 3>>();
    const auto q = pose.at("quaternion_xyzw").get<std::array<double, 4>>();
    map.world_T_map = {checked_quaternion(file.string(), {q[0], q[1], q[2], q[3]}),
                       {p[0], p[1], p[2]}};
    for (const nlohmann::ordered_json& session : place.at("sessions")) {
      map.sessions.push_back({.name = session.at("name").get<std::string>(),
                              .begin = Time(session.at("begin_ns").get<std::int64_t>()),
                              .end = Time(session.at("end_ns").get<std::int64_t>()),
                              .cameras = session.at("cameras").get<int>()});
    }
  } catch (const nlohmann::json::exception&) {
    throw InputError(
        fmt::format("{}: place_in_map: expected world_T_map and sessions, because there is a "
                    "prior_map.csv",
                    file.string()));
  }
  return map;
}

std::optional<MapSketch> read_prior_map(const std::filesystem::path& folder,
                                        const nlohmann::ordered_json& summary) {
  const std::filesystem::path file = folder / "prior_map.csv";
  if (!std::filesystem::exists(file)) return std::nullopt;
  MapSketch map = place_in_map(summary, folder / "summary.json");
  CsvReader csv(file, prior_map_columns(), {}, LastLine::kMustEnd);
  while (csv.next()) {
    SketchPoint& l = map.points.emplace_back();
    l.id = csv.integer(0);
    l.session = small_integer(csv, 1);
    if (l.session < 0 || std::cmp_greater_equal(l.session, map.sessions.size())) {
      throw InputError(fmt::format("{}: {} is no session of the map, which has {}", csv.where(1),
                                   l.session, map.sessions.size()));
    }
    l.p_map = point_at(csv, 2);
    l.covariance = symmetric_at(csv, 5);
    l.own = csv.number(11);
    l.observations = small_integer(csv, 12);
    l.views = small_integer(csv, 13);
  }
  return map;
}

// The name in the summary, else that of the folder.
std::string recording_name(const nlohmann::ordered_json& summary,
                           const std::filesystem::path& folder) {
  const auto name = summary.find("name");
  if (name != summary.end() && name->is_string()) return name->get<std::string>();
  return valid_utf8(folder_name(folder));
}

std::optional<Georeference> georeference(const nlohmann::ordered_json& summary,
                                         const std::filesystem::path& folder) {
  const auto found = summary.find("georeference");
  if (found == summary.end()) return std::nullopt;
  const auto number = [&](const char* key, double most) {
    const auto entry = found->is_object() ? found->find(key) : found->end();
    if (entry != found->end() && entry->is_number() && std::abs(entry->get<double>()) <= most) {
      return entry->get<double>();
    }
    throw InputError(fmt::format("{}: georeference: expected '{}', a number of at most {}",
                                 (folder / "summary.json").string(), key, most));
  };
  // The Mercator projection does not reach the poles.
  return Georeference{{.latitude = number("latitude", 89),
                       .longitude = number("longitude", 360),
                       .altitude = number("altitude", 1e6)}};
}

nlohmann::ordered_json parsed_summary(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "summary.json";
  return parse_json_object(read_file(file), file.string());
}

// Of a folder whose summary does not list its files, as earlier versions wrote it.
void check_frames(const std::filesystem::path& folder, const nlohmann::ordered_json& summary,
                  std::size_t states) {
  const auto frames = summary.find("frames");
  if (frames == summary.end() || !frames->is_number() || *frames == states) return;
  throw InputError(
      fmt::format("{}: has {} rows, summary.json states {} frames: the files are of two runs, or a "
                  "copy was cut "
                  "off; copy the folder again, or run again",
                  (folder / "states.csv").string(), states, json_text(*frames)));
}

TruthPairing truth_pairing(const nlohmann::ordered_json& summary,
                           const std::filesystem::path& folder) {
  TruthPairing result;
  const std::string file = (folder / "summary.json").string();
  if (const auto found = summary.find("pairing"); found != summary.end()) {
    const auto choice =
        found->is_string() ? choice_of<Pairing>(found->get<std::string>()) : std::nullopt;
    if (!choice) {
      throw InputError(
          fmt::format("{}: pairing: expected {}", file, fmt::join(kChoiceNames<Pairing>, " or ")));
    }
    result.pairing = *choice;
  }
  if (const auto found = summary.find("max_truth_gap"); found != summary.end()) {
    const double gap = found->is_number() ? found->get<double>() : -1;
    if (!(gap >= 0 && gap <= kMostTruthGap)) {
      throw InputError(
          fmt::format("{}: max_truth_gap: expected seconds from 0 to {:g}", file, kMostTruthGap));
    }
    result.longest_gap = from_seconds(gap);
  }
  return result;
}

Trajectory read_where_present(const std::filesystem::path& file) {
  return std::filesystem::exists(file) ? read_tum(file) : Trajectory();
}

}  // namespace

Run read_run(const std::filesystem::path& folder) {
  finish_replacement(folder);
  if (!std::filesystem::exists(folder / "states.csv")) {
    const std::filesystem::path growing = growing_folder(folder);
    throw InputError(
        fmt::format("{}: is no run folder: it holds no states.csv{}", folder.string(),
                    !std::filesystem::exists(growing / "states.csv") ? ""
                    : is_growing(folder)
                        ? "; a run is being written into it"
                        : fmt::format("; of a run that was killed there is {}", growing.string())));
  }
  Run run;
  const nlohmann::ordered_json summary = parsed_summary(folder);
  check_run_files(folder, summary);
  run.name = recording_name(summary, folder);
  run.georeference = georeference(summary, folder);
  run.pairing = truth_pairing(summary, folder);
  read_states(folder / "states.csv", summary, run);
  check_frames(folder, summary, run.states.size());
  if (std::filesystem::exists(folder / "timing.csv")) {
    read_timing(folder / "timing.csv", run);
  }
  run.smoothed = read_smoothed(folder / "smoothed.csv");
  run.in_map = read_smoothed(folder / "in_map.csv");
  run.prior_map = read_prior_map(folder, summary);
  run.landmarks = read_landmarks(folder / "landmarks.csv");
  run.truth = read_where_present(folder / "truth.tum");
  run.dead_reckoning = read_where_present(folder / "dead_reckoning.tum");
  run.plan = read_plan_of(folder);
  run.images = read_shown_images(folder);
  return run;
}

nlohmann::ordered_json read_summary(const std::filesystem::path& folder) {
  nlohmann::ordered_json summary = parsed_summary(folder);
  for (const char* of_the_folder : {"files", kStatesBytes}) summary.erase(of_the_folder);
  return summary;
}

}  // namespace chasles
