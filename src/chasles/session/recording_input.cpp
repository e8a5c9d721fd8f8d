#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/eval/association.hpp>
#include <chasles/recording/backwards.hpp>
#include <chasles/recording/image_views.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/session/camera_choice.hpp>
#include <chasles/session/recording_input.hpp>
#include <chasles/session/remarks.hpp>
#include <chasles/session/truth_preparation.hpp>

namespace chasles {
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

void cut(Recording& r, const RecordingInput& input) {
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

void choose_tracks(Recording& r, const TracksPart& tracks) {
  if (!tracks.part) return;
  for (FeatureFrame& frame : r.frames) tracks.thin(frame);
  r.remarks.push_back(
      fmt::format("the run uses {}a random part of the tracks: {:g} of all, seed {}",
                  tracks.rest ? "the rest of " : "", *tracks.part, tracks.seed));
}

bool common_time(const Trajectory& a, const Trajectory& b) {
  return !a.empty() && !b.empty() && a.front().time <= b.back().time &&
         b.front().time <= a.back().time;
}

// The offset of its clock, if the gyroscope shows it.
std::string likely_offset(const Recording& r) {
  if (r.imu.empty() || !r.truth_attitudes) return "";
  const TruthExamination examination =
      examine_truth(gyroscope_reference(r), r.truth, {.gap = r.pairing.longest_gap});
  for (const TruthFinding& finding : examination.findings) {
    if (finding.fault == TruthFault::kClock) return "; " + sentence(finding);
  }
  return "";
}

// Finds out before the run that a truth does not belong to the recording. With an offset that is
// still to be found, this shows at the end.
void check_truth(const Recording& r, const std::filesystem::path& file,
                 const TruthOptions& options) {
  if (is_offset_auto(options)) return;
  Trajectory stamps;
  for (std::size_t i = 0; i < frame_count(r); ++i) {
    stamps.push_back({.time = frame_time(r, i), .pose = {}});
  }
  try {
    associate(stamps, r.truth, r.pairing);
  } catch (const InputError& error) {
    std::string hint = likely_offset(r);
    if (hint.empty() && !common_time(stamps, r.truth)) {
      hint = "; --truth-time-offset auto finds the offset of two clocks by the motion";
    }
    throw InputError(fmt::format("{}: does not fit the recording's frames: {}{}", file.string(),
                                 error.what(), hint));
  }
}

}  // namespace

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

void replace_truth(Recording& r, const std::filesystem::path& file, const TruthOptions& options) {
  StatedTruth truth = read_truth(file, r.remarks);
  // Before it is mended: what begins at the identity then begins elsewhere.
  truth.level = is_truth_level(options, stated_level(truth), truth.poses);
  mend_truth(options, known_frames(r), truth);
  set_truth(std::move(truth), r);
  // That the recording has none is of no interest then.
  std::erase_if(r.remarks,
                [](const std::string& remark) { return remark.starts_with("no truth: "); });
  r.plan.clear();  // its frame is the world of the recording's own truth
  r.georeference.reset();
}

void mend_own_truth(Recording& r, const TruthOptions& options) {
  StatedTruth truth = own_truth(r);
  mend_truth(options, known_frames(r), truth);
  set_truth(std::move(truth), r);
  const bool other = changes_poses(options) || is_offset_auto(options);
  if (other) r.true_motion.clear();
  for (TrueMotion& motion : r.true_motion) motion.time += from_seconds(stated_offset(options));
  if (changes_poses(options)) {  // what is in the truth's world stays behind
    r.true_landmarks.clear();
    r.plan.clear();
    r.georeference.reset();
  }
}

Recording read_input(const RecordingInput& input) {
  check_seconds("--start", input.start);
  check_seconds("--stop", input.stop);
  ReaderSettings reader = input.reader;
  const auto choice = camera_choice(input.cameras);
  reader.cameras = cameras_to_read(choice);
  Recording r = read_recording(input.recording, reader);
  const RemarksOnError remarks(r);
  check_not_empty(r);
  r.pairing = pairing_from(input.truth_options);
  const bool level = is_truth_level(input.truth_options, stated_level(own_truth(r)), r.truth);
  if (!r.truth.empty()) r.truth_level = level;  // before its first pose becomes its last
  cut(r, input);
  if (choice) choose_cameras(r, *choice);
  choose_tracks(r, input.tracks);
  if (input.backwards) r = backwards(std::move(r));
  check_not_empty(r);
  if (!input.truth.empty()) {
    replace_truth(r, input.truth, input.truth_options);
    check_truth(r, input.truth, input.truth_options);
  } else if (!r.truth.empty()) {
    mend_own_truth(r, input.truth_options);
  }
  if (are_errors_auto(input.truth_options) && r.truth.empty()) {
    throw UsageError(fmt::format(
        "--truth-errors auto: {} has no true trajectory; give one with --truth", r.name));
  }
  return r;
}

}  // namespace chasles
