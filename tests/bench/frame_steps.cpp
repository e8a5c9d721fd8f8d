#include "frame_steps.hpp"

#include <algorithm>
#include <array>
#include <map>

#include <chasles/lab/trial.hpp>
#include <chasles/sim/inertial_sim.hpp>

namespace chasles::bench {
namespace {

constexpr double kRelativeDepthSigma = 0.1;

Recording simulate(int cameras, double seconds) {
  InertialScene scene = inertial_scene("walk");
  scene.settings.cameras = cameras;
  scene.settings.frame_rate = 10;
  scene.settings.landmarks_in_view = 120;
  scene.settings.shortest_track = 3;
  scene.settings.walk_duration = seconds;
  return simulate_inertial(scene);
}

InertialSlamSettings settings() {
  InertialSlamSettings s;
  s.landmarks = LandmarkForm::kCartesian;
  s.min_landmarks = 0;  // otherwise landmarks would be anchored
  s.frames_per_clone = 1;
  return s;
}

/// Rows of the state that are added and removed together.
struct Part {
  int row = 0, size = 0;
  const Landmark* landmark = nullptr;  ///< none: a clone
};

// By row; the keys are those of a landmark or of a clone.
std::vector<std::pair<std::pair<int, LandmarkId>, Part>> parts(const State& x) {
  std::vector<std::pair<std::pair<int, LandmarkId>, Part>> all;
  for (const Landmark& l : x.landmarks) all.push_back({{0, l.id}, {l.row, 3, &l}});
  for (const Clone& c : x.clones) {
    all.push_back({{1, static_cast<LandmarkId>(c.id)}, {c.row, 6, nullptr}});
  }
  std::sort(all.begin(), all.end(),
            [](const auto& a, const auto& b) { return a.second.row < b.second.row; });
  return all;
}

Fresh initialise(LandmarkId id, const Part& part, const State& x) {
  if (!part.landmark) {
    return {.is_clone = true,
            .id = id,
            .d_pose = Eigen::MatrixXd::Identity(6, 6),
            .noise = Eigen::MatrixXd::Zero(6, 6)};
  }
  const Eigen::Vector3d ray = x.p_world(*part.landmark) - x.world_T_imu.p;
  Fresh fresh{.id = id,
              .d_pose = Eigen::MatrixXd::Zero(3, 6),
              .noise = kRelativeDepthSigma * kRelativeDepthSigma * ray * ray.transpose()};
  fresh.noise.diagonal().array() += 1e-5 * ray.squaredNorm();  // across: 1.4 px
  fresh.d_pose.leftCols<3>() = -hat(ray);
  fresh.d_pose.rightCols<3>().setIdentity();
  return fresh;
}

void exchange(const State& before, const State& after, FrameStep& step) {
  for (int i = 0; i < before.core_size(); ++i) step.keep.push_back(i);
  std::map<std::pair<int, LandmarkId>, bool> known;
  const auto now = parts(after);
  for (const auto& [key, part] : now) known[key] = false;
  int landmark = 0;
  for (const auto& [key, part] : parts(before)) {
    const int index = part.landmark ? landmark++ : 0;
    if (known.contains(key)) {
      known[key] = true;
      for (int i = 0; i < part.size; ++i) step.keep.push_back(part.row + i);
    } else if (part.landmark) {
      step.retired.push_back(index);
    } else {
      step.removed.push_back(static_cast<int>(key.second));
    }
  }
  for (const auto& [key, part] : now) {
    if (!known[key]) step.fresh.push_back(initialise(key.second, part, after));
  }
}

void linearise(const Recording& recording, const FeatureFrame& frame, const State& before,
               FrameStep& step) {
  const auto& landmarks = step.state.landmarks;
  for (const PixelObservation& o : frame.pixels) {
    const auto is_seen = [&](const Landmark& l) { return l.id == o.landmark; };
    const auto l = std::find_if(landmarks.begin(), landmarks.end(), is_seen);
    if (l == landmarks.end() ||
        std::none_of(before.landmarks.begin(), before.landmarks.end(), is_seen)) {
      continue;
    }
    auto z = measure_pixel(recording.cameras[static_cast<std::size_t>(o.camera)], 1, step.state,
                           static_cast<int>(l - landmarks.begin()), o.pixel);
    if (z) step.used.push_back(*z);
  }
}

}  // namespace

Walk record_walk(int cameras, double seconds) {
  const Recording recording = simulate(cameras, seconds);
  const InertialStart start = draw_start(recording, settings(), 1, 0);
  const ImuBuffer::Options imu_options{.convention = recording.imu_convention};
  InertialSlam slam(settings(), recording.cameras, *recording.imu_noise, imu_options, 1, start);
  ImuBuffer imu(imu_options);
  const InertialModel model{.noise = *recording.imu_noise};
  Walk walk{.core_covariance = slam.filter().core_covariance(), .frames = {}};
  Time now = start.time;
  EventStream events(recording);
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) {
      slam.process(*sample);
      imu.add(*sample);
    }
    const auto* frame = std::get_if<FeatureFrame>(&*event);
    if (!frame || frame->time < start.time) continue;
    const State before = slam.filter().state();
    FrameStep step{.prediction = predict(model, before, imu.between(now, frame->time))};
    now = frame->time;
    slam.process(*frame);
    step.state = slam.filter().state();
    exchange(before, step.state, step);
    linearise(recording, *frame, before, step);
    walk.frames.push_back(std::move(step));
  }
  return walk;
}

}  // namespace chasles::bench
