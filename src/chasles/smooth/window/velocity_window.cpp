#include <algorithm>

#include <chasles/base/error.hpp>
#include <chasles/base/processor_time.hpp>
#include <chasles/base/validate.hpp>
#include <chasles/estimate/health.hpp>
#include <chasles/smooth/batch/batch_solve_detail.hpp>
#include <chasles/smooth/batch/velocity_problem_detail.hpp>
#include <chasles/smooth/window/velocity_window.hpp>
#include <chasles/smooth/window/window_tracks_detail.hpp>

namespace chasles {

using namespace smooth_detail;

struct VelocityWindow::Implementation {
  using Tracks = WindowTracks<VelocityPoint>;

  Implementation(const VelocityBatchInput& in, const BatchSettings& s, int keyframes)
      : input{.rig = in.rig,
              .settings = validated(in.settings),
              .noise = in.noise,
              .velocities = {},
              .frames = {}},
        settings(with_loss_width(validated(s), in.noise)),
        timeline(input.settings, input.noise),
        sliding(keyframes, settings, error_chart(input.settings.chart),
                {.velocity = false, .additive = timeline.model.size()}),
        report() {
    report.window = keyframes;
    check_noise(input);
  }

  void make_room();
  void take(int keyframe);
  void observe(const StereoObservation& observation, int now);
  void initialise(Tracks::Track& track);
  WindowView view_of(const StereoView& view, bool first) const;
  Estimate estimate(const FeatureFrame& frame, const SlidingWindow::Optimised& optimised);

  VelocityBatchInput input;
  BatchSettings settings;
  VelocityTimeline timeline;
  SlidingWindow sliding;
  WindowReport report;
  Tracks tracks;
  RecentUse recent;
  int frames = 0, last_frame = -1, fresh = 0, gated = 0;
};

WindowView VelocityWindow::Implementation::view_of(const StereoView& view, bool first) const {
  const StereoRows rows = view_rows(input.settings, first);
  const StereoNoise& noise = first ? input.noise.initialisation : input.noise.update;
  const bool anchored = sliding.window.anchored;
  WindowView made =
      rows == StereoRows::kMean
          ? window_view(stereo_term<2>(input.rig, rows, noise, view.pixels), anchored)
      : rows == StereoRows::kMeanDisparity
          ? window_view(stereo_term<3>(input.rig, rows, noise, view.pixels), anchored)
          : window_view(stereo_term<4>(input.rig, rows, noise, view.pixels), anchored);
  made.keyframe = view.keyframe;
  made.begins = first;
  return made;
}

void VelocityWindow::Implementation::make_room() {
  if (!sliding.make_room()) return;
  tracks.drop(sliding.window);
  timeline.drop_before(sliding.window.first);
}

// Adds the timeline's keyframe, with the terms that end there, to the window.
void VelocityWindow::Implementation::take(int k) {
  Window& window = sliding.window;
  if (!window.keyframes.empty() && k <= window.last()) return;
  const VelocityKeyframe& keyframe = timeline.keyframes[static_cast<std::size_t>(k)];
  std::array<double, kPoseNumbers> motion{};
  write_pose(keyframe.state.world_T_imu, motion.data());
  sliding.push(keyframe.time, motion.data(), keyframe.state.additive);
  ++report.keyframes;
  if (k == 0) {
    window.terms.push_back({.cost = std::make_unique<VelocityStartCost>(timeline.start)});
  } else {
    window.terms.push_back({.first = k - 1,
                            .keyframes = 2,
                            .cost = std::make_unique<TwistCost>(timeline.links.back())});
  }
}

void VelocityWindow::Implementation::observe(const StereoObservation& o, int now) {
  Tracks::Track& track = tracks.of(o.landmark);
  std::vector<StereoView>& views = track.of.views;
  if (!views.empty() && views.back().keyframe == now) {  // two frames of one instant
    ++report.unusable;
    return;
  }
  if (!settings.loops && !views.empty() && views.back().keyframe < last_frame) {
    track = {.of = {.id = o.landmark, .views = {}}};
  }
  views.push_back({.keyframe = now, .pixels = o.pixels});
  if (!track.point) return initialise(track);
  sliding.observe(*track.point, view_of(views.back(), false));
  ++report.observations;
}

void VelocityWindow::Implementation::initialise(Tracks::Track& track) {
  VelocityPoint point = track.of;
  if (!initialise_with_disparity(input.rig, input.settings, point) || point.views.size() < 2)
    return;
  place(input.rig, sliding.window.anchored, timeline.keyframes, point);
  WindowPoint made{.id = point.id,
                   .anchor = point.views.front().keyframe,
                   .cam_T_imu = input.rig.cam0_T_imu,
                   .parameters = point.parameters};
  for (const StereoView& view : point.views) {
    made.views.push_back(view_of(view, &view == &point.views.front()));
  }
  track.of.views = point.views;
  tracks.initialise(track, sliding.add(std::move(made)));
  ++report.landmarks;
  report.observations += static_cast<int>(point.views.size());
}

Estimate VelocityWindow::Implementation::estimate(const FeatureFrame& frame,
                                                  const SlidingWindow::Optimised& optimised) {
  const Window& window = sliding.window;
  const WindowKeyframe& newest = window.keyframes.back();
  Estimate e;
  e.time = frame.time;
  e.world_T_imu = read_pose(newest.motion.data());
  e.additive = newest.additive;
  e.covariance = sliding.newest_covariance();
  e.observations = static_cast<int>(frame.observations.size());
  e.rejected = gated;
  e.added = fresh;
  for (const auto& [number, point] : window.points) {
    e.used += !point.views.empty() && point.views.back().keyframe == window.last() ? 1 : 0;
  }
  e.in_state = static_cast<int>(window.points.size());
  e.landmarks = sliding.map_size();
  if (!optimised.finite || !e.world_T_imu.p.allFinite() || !e.pose_covariance().allFinite()) {
    e.health = Health::kLost;
    return e;
  }
  e.degradation =
      recent.assess(frame.time, e.used, e.rejected, optimised.squares, optimised.residuals);
  if (e.degradation != Degradation::kNone) e.health = Health::kDegraded;
  return e;
}

VelocityWindow::VelocityWindow(const VelocityBatchInput& input, const BatchSettings& settings,
                               int keyframes)
    : of_(std::make_unique<Implementation>(input, settings, keyframes)) {}

VelocityWindow::~VelocityWindow() = default;

void VelocityWindow::process(const BodyVelocity& velocity) {
  Implementation& w = *of_;
  const double started = processor_seconds();
  w.make_room();
  const std::size_t samples = w.timeline.samples.size();
  const int k = w.timeline.add(velocity);
  w.take(k);
  if (w.timeline.samples.size() > samples) {
    w.sliding.window.terms.push_back(
        {.first = k,
         .additive_only = !w.timeline.model.level,
         .cost = std::make_unique<SampleCost>(w.timeline.model, w.timeline.samples.back())});
  }
  w.report.seconds += processor_seconds() - started;
}

std::optional<Estimate> VelocityWindow::process(const FeatureFrame& frame) {
  Implementation& w = *of_;
  if (w.frames++ % w.settings.frames_per_keyframe != 0) return std::nullopt;
  const double started = processor_seconds();
  w.make_room();
  const int now = w.timeline.add(frame);
  w.take(now);
  Window& window = w.sliding.window;
  window.keyframe(now).framed = true;
  const int landmarks = w.report.landmarks;
  for (const StereoObservation& o : usable(frame, w.report.unusable)) w.observe(o, now);
  w.fresh = w.report.landmarks - landmarks;
  w.last_frame = now;
  const SlidingWindow::Optimised optimised = w.sliding.optimise(w.report);
  w.gated =
      static_cast<int>(std::ranges::count(optimised.culled.views, now, &CulledView::keyframe));
  w.tracks.drop(optimised.culled, w.report);
  for (int k = window.first; k <= window.last(); ++k) {
    VelocityState& state = w.timeline.keyframes[static_cast<std::size_t>(k)].state;
    state.world_T_imu = read_pose(window.keyframe(k).motion.data());
    state.additive = window.keyframe(k).additive;
  }
  const Estimate e = w.estimate(frame, optimised);
  w.report.seconds += processor_seconds() - started;
  return e;
}

std::vector<MapLandmark> VelocityWindow::map() const { return of_->sliding.map(); }

std::vector<LandmarkId> VelocityWindow::in_window() const {
  std::vector<LandmarkId> ids;
  for (const auto& [number, point] : of_->sliding.window.points) ids.push_back(point.id);
  return ids;
}

const WindowReport& VelocityWindow::report() const { return of_->report; }

void VelocityWindow::check() const {
  if (of_->report.landmarks > 0) return;
  throw InputError(
      "a window needs landmarks that are observed twice: none in the recording is, or none with a "
      "disparity (" +
      std::to_string(of_->report.unusable) + " observations were not usable)");
}

}  // namespace chasles
