#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/pipeline/measured_offset.hpp>
#include <chasles/reconstruct/recording_of_run.hpp>
#include <chasles/session/camera_choice.hpp>
#include <chasles/viewers/run_path.hpp>

namespace chasles {

std::vector<std::size_t> cameras_of_run(const std::string& summary) {
  imu_T_camera(summary, 0);  // throws for a run without cameras
  const std::size_t count = nlohmann::json::parse(summary).at("cameras").size();
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < count; ++i) numbers.push_back(recorded_camera(summary, i));
  return numbers;
}

Recording as_in_run(Recording recording, const std::string& summary,
                    const InertialRunSettings& settings) {
  const std::vector<std::size_t> cameras = cameras_of_run(summary);
  try {
    choose_cameras(recording, cameras);
  } catch (const UsageError& error) {
    throw InputError(fmt::format("the recording is not that of the run: {}", error.what()));
  }
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    recording.cameras[i].cam_T_imu = imu_T_camera(summary, i).inverse();
  }
  mend(recording, settings.filter, examine_tracks(recording, settings));
  return recording;
}

}  // namespace chasles
