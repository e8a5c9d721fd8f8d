#include <cmath>
#include <optional>
#include <string>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/csv.hpp>
#include <chasles/recording/euroc_tables.hpp>
#include <chasles/recording/gravity.hpp>
#include <chasles/recording/image_recording.hpp>
#include <chasles/recording/imu_table.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/truth_table.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

constexpr double kLevel = 0.1;  // [deg], accuracy of the fit

// Removes an ending if present.
std::string without(std::string text, const std::string& ending) {
  if (text.ends_with(ending)) text.resize(text.size() - ending.size());
  return text;
}

// V1_01_easy from V1_01_easy_imu.csv.gz.
std::string sequence_of(const fs::path& file) {
  return without(without(without(file.filename().string(), ".gz"), ".csv"), "_imu");
}

std::optional<fs::path> truth_beside(const fs::path& file) {
  for (const char* ending : {"_gt.csv.gz", "_gt.csv", "_gt.txt.gz", "_gt.txt"}) {
    const fs::path truth = file.parent_path() / (sequence_of(file) + ending);
    if (fs::exists(truth)) return truth;
  }
  return std::nullopt;
}

// The truth is not changed; a remark reports how level its world is.
void remark_on_gravity(Recording& recording) {
  const auto fit = fit_gravity(recording.truth, recording.imu);
  if (!fit) return;
  const Eigen::Vector3d down = fit->gravity_world.normalized();
  const double degrees = std::atan2(down.head<2>().norm(), -down.z()) * 180 / M_PI;
  if (degrees < kLevel) return;
  recording.remarks.push_back(fmt::format(
      "gravity, as the samples show it, leans {:.1f} deg from the truth's z axis: its world is not "
      "level",
      degrees));
}

void read_truth_file(const fs::path& file, Recording& recording) {
  const std::string name = file.filename().string();
  if (name.find("_gt.csv") != std::string::npos) {
    read_euroc_states(file, recording);
  } else {
    read_poses_alone(file, recording);
  }
  if (recording.truth.empty()) return;
  const double late = to_seconds(recording.truth.front().time - recording.imu.front().time);
  const double early = to_seconds(recording.imu.back().time - recording.truth.back().time);
  recording.remarks.push_back(fmt::format(
      "the truth begins {:.2f} s {} the first IMU sample and ends {:.2f} s {} the last one",
      std::abs(late), late < 0 ? "before" : "after", std::abs(early),
      early < 0 ? "after" : "before"));
  remark_on_gravity(recording);
}

}  // namespace

Recording read_euroc_imu_recording(const fs::path& file) {
  Recording recording;
  recording.name = sequence_of(file);
  recording.imu = read_imu_table(file, recording.remarks);
  tidy_samples(file, recording);
  remark_on_open_end(file, recording.remarks);
  if (const auto truth = truth_beside(file)) {
    read_truth_file(*truth, recording);
  } else {
    recording.remarks.push_back(
        fmt::format("no truth: there is no {}_gt.csv (or .txt, .gz) beside", recording.name));
  }
  return recording;
}

}  // namespace chasles
