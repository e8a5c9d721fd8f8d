#include <algorithm>
#include <fstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/calibration/calibration.hpp>
#include <chasles/codec/gzip.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/yaml_map.hpp>
#include <chasles/recording/euroc_tables.hpp>
#include <chasles/recording/pose_columns.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/truth_table.hpp>
#include <chasles/session/truth_mending.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

// Whether a file is a recording, which may have the truth, and not a trajectory.
bool is_recording(const fs::path& file) {
  check_regular_file(file);
  std::ifstream stream(file, std::ios::binary);
  std::string head(512, '\0');
  stream.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(stream.gcount()));
  if (is_gzip(head)) head = read_plain_or_gzip(file);
  const bool text = std::ranges::none_of(head.substr(0, 512), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte < 0x20 && c != '\n' && c != '\r' && c != '\t';
  });
  return !text || head.starts_with("PK") || head.starts_with("MATLAB") || begins_euroc_imu(head) ||
         begins_klt_tracks(head);
}

// "walk.mcap:/vicon/pose" is a bag and one of its topics.
std::pair<fs::path, std::string> bag_and_topic(const fs::path& path) {
  std::error_code ignored;
  const std::string text = path.string();
  if (fs::exists(path, ignored)) return {path, ""};
  for (std::size_t colon = text.find(':'); colon != std::string::npos;
       colon = text.find(':', colon + 1)) {
    const fs::path bag = text.substr(0, colon);
    if (is_bag(bag)) return {bag, text.substr(colon + 1)};
  }
  return {path, ""};
}

StatedTruth stated(TruthTable&& table, std::optional<bool> level = {}) {
  return {.poses = std::move(table.poses),
          .level = level,
          .attitudes = table.attitudes,
          .point_imu = table.point_imu};
}

// imu_T_truth of a YAML file.
SE3 transform_of_yaml(const fs::path& file) {
  const YamlMap map = YamlMap::read(file, {});
  for (const char* key : {"imu_T_truth", "T_BS", "T_imu_truth"}) {
    if (map.has(key)) return map.motion(key);
  }
  if (map.has("truth_T_imu")) return map.motion("truth_T_imu").inverse();
  throw InputError(
      fmt::format("{}: has none of the keys imu_T_truth, T_BS and truth_T_imu, expected "
                  "one, with four rows of four numbers",
                  file.string()));
}

SE3 transform_of_text(const fs::path& file) {
  const std::string text = read_text(file);
  std::string_view rest = text;
  std::vector<double> numbers;
  while (!rest.empty()) {
    const std::string_view line = trimmed(take_line(rest));
    if (line.empty() || line.front() == '#') continue;
    for (const std::string_view word : split_row(line)) {
      numbers.push_back(parse_finite(file.string(), word));
    }
  }
  if (numbers.size() != 16) {
    throw InputError(
        fmt::format("{}: has {} numbers, expected 16: imu_T_truth, four rows of four "
                    "numbers",
                    file.string(), numbers.size()));
  }
  const Eigen::Matrix4d M =
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
  return checked_motion(file.string(), M);
}

SE3 imu_T_truth(const std::string& name, const std::vector<KnownFrame>& frames) {
  if (name == "imu") return {};
  const auto known = std::ranges::find(frames, name, &KnownFrame::name);
  if (known != frames.end()) return known->imu_T_frame;
  std::error_code ignored;
  if (fs::exists(name, ignored)) {
    const std::string ending = fs::path(name).extension().string();
    return ending == ".yaml" || ending == ".yml" ? transform_of_yaml(name)
                                                 : transform_of_text(name);
  }
  std::string names = "imu";
  for (const KnownFrame& frame : frames) names += ", " + frame.name;
  throw UsageError(fmt::format(
      "--truth-frame: found '{}', expected {} or a file with imu_T_truth{}", name, names,
      frames.empty() ? " (a trajectory alone has no calibration: a run folder has one)" : ""));
}

}  // namespace

StatedTruth read_truth(const fs::path& path, std::vector<std::string>& remarks) {
  std::error_code ignored;
  const auto [bag, topic] = bag_and_topic(path);
  if (!topic.empty() || is_bag(bag)) return stated(read_bag_truth(bag, topic, remarks));
  const bool folder = fs::is_directory(path, ignored);
  if (folder && fs::exists(path / "truth.tum", ignored)) {
    const fs::path calibration = path / "calibration.yaml";
    return stated(read_truth_table(path / "truth.tum", remarks),
                  fs::exists(calibration, ignored) ? read_calibration(calibration).truth_level
                                                   : std::nullopt);
  }
  if (!folder && !is_recording(path)) return stated(read_truth_table(path, remarks));
  const Recording recording = read_recording(path);
  if (recording.truth.empty()) {
    throw InputError(
        fmt::format("{}: has no true trajectory; expected a TUM file, or a recording "
                    "with the truth",
                    path.string()));
  }
  return own_truth(recording);
}

StatedTruth own_truth(const Recording& recording) {
  return {.poses = recording.truth,
          .level = recording.truth_level,
          .attitudes = recording.truth_attitudes,
          .point_imu = recording.truth_point_imu};
}

void set_truth(StatedTruth&& truth, Recording& recording) {
  recording.truth = std::move(truth.poses);
  recording.truth_level = truth.level;
  recording.truth_attitudes = truth.attitudes;
  recording.truth_point_imu = truth.point_imu;
}

std::optional<bool> stated_level(const StatedTruth& truth) {
  return truth.attitudes ? truth.level : truth.level.value_or(true);
}

std::vector<KnownFrame> known_frames(const Recording& recording) {
  std::vector<KnownFrame> frames;
  for (const Camera& camera : recording.cameras) {
    frames.push_back({fmt::format("cam{}", frames.size()), camera.cam_T_imu.inverse()});
  }
  if (frames.empty() && recording.rig.fx > 0) {
    frames.push_back({"cam0", recording.rig.cam0_T_imu.inverse()});
  }
  return frames;
}

std::vector<KnownFrame> known_frames(const nlohmann::ordered_json& summary) {
  std::vector<KnownFrame> frames;
  const auto cameras = summary.find("cameras");
  if (cameras == summary.end() || !cameras->is_array()) return frames;
  for (const auto& camera : *cameras) {
    KnownFrame frame{.name = fmt::format("cam{}", frames.size()), .imu_T_frame = {}};
    try {
      const auto rows = camera.at("imu_T_cam").get<std::vector<std::vector<double>>>();
      for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
          frame.imu_T_frame.R(i, k) =
              rows.at(static_cast<std::size_t>(i)).at(static_cast<std::size_t>(k));
        }
        frame.imu_T_frame.p[i] = rows.at(static_cast<std::size_t>(i)).at(3);
      }
    } catch (const std::exception& error) {
      throw InputError(
          fmt::format("summary.json: cameras: imu_T_cam: expected four rows of four "
                      "numbers ({})",
                      error.what()));
    }
    frames.push_back(frame);
  }
  return frames;
}

bool changes_poses(const TruthOptions& options) {
  return options.inverse || options.scale || (!options.frame.empty() && options.frame != "imu");
}

void mend_truth(const TruthOptions& options, const std::vector<KnownFrame>& frames,
                StatedTruth& truth) {
  if (options.inverse && !truth.attitudes) {
    throw UsageError("--truth-inverse: the truth has positions alone, expected poses");
  }
  const SE3 frame = options.frame.empty() ? SE3{} : imu_T_truth(options.frame, frames);
  const SE3 frame_T_imu = frame.inverse();
  const Time offset = from_seconds(stated_offset(options));
  for (StampedPose& row : truth.poses) {
    if (options.inverse) row.pose = row.pose.inverse();
    if (options.scale) row.pose.p *= *options.scale;
    if (truth.attitudes && !options.frame.empty()) row.pose = row.pose * frame_T_imu;
    row.time += offset;
  }
  if (!truth.attitudes && !options.frame.empty()) truth.point_imu = frame.p;
}

}  // namespace chasles
