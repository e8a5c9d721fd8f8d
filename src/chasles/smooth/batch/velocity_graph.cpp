#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include <chasles/base/error.hpp>
#include <chasles/smooth/batch/batch_solve_detail.hpp>
#include <chasles/smooth/batch/initial_error_detail.hpp>
#include <chasles/smooth/batch/velocity_graph_detail.hpp>
#include <chasles/velocity/velocity_model.hpp>

namespace chasles::smooth_detail {
namespace {

// Velocities and frames in order of time, a velocity before a frame of the same time; collects the
// views of every landmark.
class VelocityCollector {
 public:
  VelocityCollector(const VelocityBatchInput& input, const BatchSettings& settings,
                    BatchReport& report)
      : input_(input),
        settings_(settings),
        report_(report),
        graph_{.timeline = VelocityTimeline(input.settings, input.noise),
               .anchored = settings.landmarks == LandmarkForm::kInverseDepth} {}

  VelocityGraph collect() {
    auto velocity = input_.velocities.begin();
    for (const FeatureFrame& frame : input_.frames) {
      for (; velocity != input_.velocities.end() && velocity->time <= frame.time; ++velocity) {
        graph_.timeline.add(*velocity);
      }
      if (frames_++ % settings_.frames_per_keyframe == 0) keep(frame);
    }
    for (; velocity != input_.velocities.end(); ++velocity) graph_.timeline.add(*velocity);
    for (auto& [id, point] : tracks_) finish(point);
    // By their first views, so that neighbours in time are neighbours in memory.
    std::ranges::stable_sort(graph_.points, {}, [](const VelocityPoint& p) {
      return std::tuple(p.views.front().keyframe, p.id);
    });
    return std::move(graph_);
  }

 private:
  void keep(const FeatureFrame& frame) {
    const int now = graph_.timeline.add(frame);
    for (const StereoObservation& o : usable(frame, report_.unusable)) {
      VelocityPoint& point = tracks_[o.landmark];
      point.id = o.landmark;
      const bool seen = !point.views.empty();
      if (seen && point.views.back().keyframe == now) {  // two frames of one instant
        ++report_.unusable;
        continue;
      }
      if (seen && !settings_.loops && point.views.back().keyframe < last_frame_) {
        finish(point);
        point = {.id = o.landmark, .views = {}};
      }
      point.views.push_back({.keyframe = now, .pixels = o.pixels});
    }
    last_frame_ = now;
  }

  void finish(VelocityPoint& point) {
    if (initialise_with_disparity(input_.rig, input_.settings, point) && point.views.size() >= 2) {
      graph_.points.push_back(std::move(point));
    } else {
      ++report_.landmarks_left_out;
    }
  }

  const VelocityBatchInput& input_;
  const BatchSettings& settings_;
  BatchReport& report_;
  VelocityGraph graph_;
  std::map<LandmarkId, VelocityPoint> tracks_;
  int frames_ = 0, last_frame_ = 0;  // the index of the last keyframe
};

// The given initial states at the same times; after other states the velocities are integrated
// anew.
void take_initial(const std::vector<Estimate>& initial, VelocityTimeline& timeline) {
  auto& keyframes = timeline.keyframes;
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    const auto known = std::ranges::lower_bound(initial, keyframes[k].time, {}, &Estimate::time);
    if (known != initial.end() && known->time == keyframes[k].time &&
        known->additive.size() == timeline.model.size()) {
      keyframes[k].state = {.world_T_imu = known->world_T_imu, .additive = known->additive};
    } else if (k > 0) {
      State x;
      x.world_T_imu = keyframes[k - 1].state.world_T_imu;
      x.additive = keyframes[k - 1].state.additive;
      const TwistLink& link = timeline.links[k - 1];
      keyframes[k].state.world_T_imu =
          x.world_T_imu * se3::exp(link.tau * corrected_velocity(timeline.model, x, link.held));
    }
  }
  // States that hardly change start everywhere at their last known value.
  const BodyVelocityModel& model = timeline.model;
  if (initial.empty() || !model.level || initial.back().additive.size() != model.size()) return;
  const auto last = initial.back().additive.segment<3>(model.tilt_index());
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    keyframes[k].state.additive.segment<3>(model.tilt_index()) = last;
  }
}

void check(const VelocityBatchInput& input) {
  if (input.velocities.empty()) {
    throw InputError("batch estimation needs velocities: the recording has none");
  }
  check_noise(input);
}

void count(VelocityGraph& graph, BatchReport& report) {
  for (const VelocityPoint& point : graph.points) {
    for (const StereoView& view : point.views) {
      ++graph.timeline.keyframes[static_cast<std::size_t>(view.keyframe)].used;
      ++report.observations;
    }
  }
  report.keyframes = static_cast<int>(graph.timeline.keyframes.size());
  report.links = static_cast<int>(graph.timeline.links.size());
  report.landmarks = static_cast<int>(graph.points.size());
}

}  // namespace

void check_noise(const VelocityBatchInput& input) {
  for (const StereoNoise* noise : {&input.noise.initialisation, &input.noise.update}) {
    for (const double sigma : {noise->u, noise->v, noise->disparity}) {
      if (sigma > 0 && std::isfinite(sigma)) continue;
      throw UsageError("pixel_sigma and disparity_sigma: found " + std::to_string(sigma) +
                       ", expected standard deviations above 0");
    }
  }
  const Vector6d& sigma = input.noise.motion.sample_sigma;
  if (sigma.allFinite() && sigma.minCoeff() > 0) return;
  throw InputError(
      "a velocity sample without noise: expected velocity_sigma and rate_sigma above 0");
}

std::vector<StereoObservation> usable(const FeatureFrame& frame, int& unusable) {
  std::vector<StereoObservation> good;
  std::set<LandmarkId> seen;
  for (const StereoObservation& o : frame.observations) {
    if (o.pixels.allFinite() && seen.insert(o.landmark).second) {
      good.push_back(o);
    } else {
      ++unusable;
    }
  }
  std::ranges::sort(good, {}, &StereoObservation::landmark);
  return good;
}

bool initialise_with_disparity(const StereoRig& rig, const VelocitySlamSettings& settings,
                               VelocityPoint& point) {
  const auto first = std::ranges::find_if(point.views, [&](const StereoView& view) {
    return view.pixels[0] - view.pixels[2] >= settings.min_disparity &&
           triangulate(rig, view.pixels);
  });
  point.views.erase(point.views.begin(), first);
  return !point.views.empty();
}

void place(const StereoRig& rig, bool anchored, const Numbered<VelocityKeyframe>& keyframes,
           VelocityPoint& point) {
  const StereoView& first = point.views.front();
  const Eigen::Vector3d p_cam0 = triangulate(rig, first.pixels)->p_cam0;
  const SE3& world_T_imu = keyframes[static_cast<std::size_t>(first.keyframe)].state.world_T_imu;
  point.parameters = anchored
                         ? Eigen::Vector3d(Eigen::Vector3d(p_cam0.x(), p_cam0.y(), 1) / p_cam0.z())
                         : world_T_imu * (rig.cam0_T_imu.inverse() * p_cam0);
}

VelocityGraph velocity_graph(const VelocityBatchInput& input, const BatchSettings& settings,
                             BatchReport& report) {
  check(input);
  VelocityGraph graph = VelocityCollector(input, settings, report).collect();
  if (std::ranges::count_if(graph.timeline.keyframes, &VelocityKeyframe::framed) < 2) {
    throw InputError("batch estimation needs two frames: there are " +
                     std::to_string(input.frames.size()));
  }
  if (graph.points.empty()) {
    throw InputError("batch estimation needs landmarks that are observed twice: of " +
                     std::to_string(report.landmarks_left_out) +
                     " landmarks none is, or none with a disparity (" +
                     std::to_string(report.unusable) + " observations were not usable)");
  }
  take_initial(input.initial, graph.timeline);
  for (VelocityPoint& point : graph.points) {
    place(input.rig, graph.anchored, graph.timeline.keyframes, point);
  }
  count(graph, report);
  add_initial_error(input, settings, graph);
  return graph;
}

BatchSettings with_loss_width(BatchSettings settings, const VelocitySlamNoise& noise) {
  constexpr double kOfInflatedNoise = 0.5;
  if (noise.pixels_inflated && !settings.loss_width) settings.loss_width = kOfInflatedNoise;
  return settings;
}

StereoRows view_rows(const VelocitySlamSettings& settings, bool first) {
  return first ? StereoRows::kMeanDisparity : settings.stereo_rows;
}

int row_count(StereoRows rows) {
  return rows == StereoRows::kAll ? 4 : rows == StereoRows::kMean ? 2 : 3;
}

Landmark landmark_of(const StereoRig& rig, const VelocityPoint& point) {
  Landmark landmark{.id = point.id};
  landmark.anchor = point.views.front().keyframe;
  landmark.cam_T_imu = rig.cam0_T_imu;
  landmark.inverse_depth = point.parameters;
  return landmark;
}

}  // namespace chasles::smooth_detail
