#include "run_input.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>

#include <fmt/format.h>

#include <chasles/data/backwards.hpp>
#include <chasles/data/calibration.hpp>
#include <chasles/data/euroc_tables.hpp>
#include <chasles/data/gzip.hpp>
#include <chasles/data/image_views.hpp>
#include <chasles/data/readers.hpp>
#include <chasles/data/text_file.hpp>
#include <chasles/error.hpp>
#include <chasles/eval/association.hpp>

#include "remarks.hpp"

namespace chasles::app {
namespace {

Time last_event(const Recording& r) {
  Time last = Time::min();
  if (!r.frames.empty()) last = std::max(last, r.frames.back().time);
  if (!r.velocities.empty()) last = std::max(last, r.velocities.back().time);
  if (!r.imu.empty()) last = std::max(last, r.imu.back().time);
  if (r.images && r.images->size() > 0) {
    last = std::max(last, r.images->time(r.images->size() - 1));
  }
  return last;
}

void check_not_empty(const Recording& r) {
  if (frame_count(r) > 0 && (!r.velocities.empty() || !r.imu.empty())) return;
  throw Error(ExitCode::kNotInitialised,
              fmt::format("{}: the recording has {} frames, {} velocities and {} IMU samples, "
                          "expected frames and one of the others",
                          r.name, frame_count(r), r.velocities.size(), r.imu.size()));
}

template <typename Events>
void keep(Events& events, Time from, Time to) {
  std::erase_if(events, [&](const auto& event) { return event.time < from || event.time > to; });
}

void check_seconds(const char* option, const std::optional<double>& seconds) {
  if (!seconds || std::isfinite(*seconds)) return;
  throw UsageError(
      fmt::format("{}: found {}, expected a finite number of seconds", option, *seconds));
}

void cut(Recording& r, const RunInput& input) {
  if (!input.start && !input.stop) return;
  const Time begin = first_event(r);
  const double length = to_seconds(last_event(r) - begin);
  const double start = std::max(0.0, input.start.value_or(0));
  const double stop = std::min(input.stop.value_or(length), length);
  if (start >= stop) {
    throw UsageError(
        fmt::format("--start {} s, --stop {} s: nothing is left of {}, which lasts "
                    "{:.3f} s",
                    start, input.stop.value_or(length), r.name, length));
  }
  keep(r.velocities, begin + from_seconds(start), begin + from_seconds(stop));
  keep(r.imu, begin + from_seconds(start), begin + from_seconds(stop));
  keep(r.frames, begin + from_seconds(start), begin + from_seconds(stop));
  if (r.images) {
    r.images = part_of(r.images, begin + from_seconds(start), begin + from_seconds(stop),
                       r.cameras.size());
  }
}

// How many of the first cameras are asked for.
std::size_t count_of(const std::string& choice) {
  if (choice.empty()) return kAllCameras;
  if (choice == "mono") return 1;
  if (choice == "stereo") return 2;
  throw UsageError(fmt::format("--cameras: found '{}', expected mono or stereo", choice));
}

// Keeps only those.
void choose_cameras(Recording& r, const std::string& choice) {
  if (choice.empty()) return;
  const std::size_t count = count_of(choice);
  if (r.cameras.size() < count) {
    throw UsageError(fmt::format("--cameras {}: {} has {} single cameras, expected at least {}",
                                 choice, r.name, r.cameras.size(), count));
  }
  r.cameras.resize(count);
  for (FeatureFrame& frame : r.frames) {
    std::erase_if(frame.pixels,
                  [&](const PixelObservation& o) { return o.camera >= static_cast<int>(count); });
  }
  if (r.images) r.images = part_of(r.images, Time::min(), Time::max(), count);
}

void choose_tracks(Recording& r, const TracksPart& tracks) {
  if (!tracks.part) return;
  for (FeatureFrame& frame : r.frames) tracks.thin(frame);
  r.remarks.push_back(fmt::format("the run uses a random part of the tracks: {:g} of all, seed {}",
                                  *tracks.part, tracks.seed));
}

// Finds out before the run that a truth does not belong to the recording.
void check_truth(const Recording& r, const std::filesystem::path& file) {
  Trajectory stamps;
  for (std::size_t i = 0; i < frame_count(r); ++i) {
    stamps.push_back({.time = frame_time(r, i), .pose = {}});
  }
  try {
    associate(stamps, r.truth, r.pairing);
  } catch (const InputError& error) {
    throw InputError(
        fmt::format("{}: does not fit the recording's frames: {}", file.string(), error.what()));
  }
}

// Whether a file is a recording, which may have the truth, and not a trajectory.
bool is_recording(const std::filesystem::path& file) {
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

}  // namespace

StatedTruth read_truth(const std::filesystem::path& path, std::vector<std::string>& remarks) {
  std::error_code ignored;
  const bool folder = std::filesystem::is_directory(path, ignored);
  if (folder && std::filesystem::exists(path / "truth.tum", ignored)) {
    const std::filesystem::path calibration = path / "calibration.yaml";
    return {.poses = read_tum(path / "truth.tum", remarks),
            .level = std::filesystem::exists(calibration, ignored)
                         ? read_calibration(calibration).truth_level
                         : std::nullopt};
  }
  if (!folder && !is_recording(path)) return {.poses = read_tum(path, remarks), .level = {}};
  Recording recording = read_recording(path);
  StatedTruth truth{.poses = std::move(recording.truth), .level = recording.truth_level};
  if (truth.poses.empty()) {
    throw InputError(
        fmt::format("{}: has no true trajectory; expected a TUM file, or a recording "
                    "with the truth",
                    path.string()));
  }
  return truth;
}

void follow(Recording& r, const Trajectory& trajectory) {
  if (trajectory.size() < 2) throw InputError("the trajectory has fewer than two poses");
  r.velocities.clear();
  for (std::size_t k = 0; k + 1 < trajectory.size(); ++k) {
    const StampedPose &now = trajectory[k], &next = trajectory[k + 1];
    const Vector6d twist =
        se3::log(now.pose.inverse() * next.pose) / to_seconds(next.time - now.time);
    r.velocities.push_back(
        {.time = now.time, .linear_imu = twist.tail<3>(), .angular_imu = twist.head<3>()});
  }
  const std::size_t all = r.frames.size();
  keep(r.frames, trajectory.front().time, trajectory.back().time);
  if (r.frames.empty()) {
    throw InputError(fmt::format("no frame of {} lies in the time span of the trajectory", r.name));
  }
  if (r.frames.size() < all) {
    r.remarks.push_back(
        fmt::format("{} of {} frames lie outside the time span of the given "
                    "trajectory: left out",
                    all - r.frames.size(), all));
  }
}

Recording read_input(const RunInput& input) {
  check_seconds("--start", input.start);
  check_seconds("--stop", input.stop);
  ReaderSettings reader = input.reader;
  reader.cameras = count_of(input.cameras);
  Recording r = read_recording(input.recording, reader);
  const RemarksOnError remarks(r);
  check_not_empty(r);
  r.pairing = pairing_from(input.truth_options);
  const bool level = is_truth_level(input.truth_options, r.truth_level, r.truth);
  if (!r.truth.empty()) r.truth_level = level;  // before its first pose becomes its last
  cut(r, input);
  choose_cameras(r, input.cameras);
  choose_tracks(r, input.tracks);
  if (input.backwards) r = backwards(std::move(r));
  check_not_empty(r);
  if (!input.truth.empty()) {
    StatedTruth truth = read_truth(input.truth, r.remarks);
    r.truth_level = is_truth_level(input.truth_options, truth.level, truth.poses);
    r.truth = std::move(truth.poses);
    check_truth(r, input.truth);
    r.plan.clear();  // its frame is the world of the recording's own truth
    r.georeference.reset();
  }
  return r;
}

}  // namespace chasles::app
