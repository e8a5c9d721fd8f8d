#include <utility>

#include <chasles/base/stage_clock.hpp>
#include <chasles/base/validate.hpp>
#include <chasles/filter/calibration.hpp>
#include <chasles/slam/inertial_slam.hpp>
#include <chasles/slam/initial_filter.hpp>

namespace chasles {
namespace {

SlamContext initial_context(const InertialSlamSettings& settings, std::vector<Camera> cameras,
                            double pixel_sigma, const InertialStart& start) {
  Ekf filter = initial_filter(validated(settings), start, cameras);
  SlamContext x{.settings = settings,
                .cameras = std::move(cameras),
                .pixel_sigma = pixel_sigma,
                .filter = std::move(filter)};
  x.now = start.time - x.clock(Time{});
  return x;
}

LoopSettings loop_settings(const SlamContext& x) {
  return {.recognise = x.settings.recognise,
          .prior_map = x.settings.prior_map,
          .recognisable = x.settings.recognisable,
          .max_rejections = x.settings.max_rejections,
          .noise = {.gate = x.pixel_sigma, .update = x.track_noise().sigma}};
}

}  // namespace

InertialSlam::InertialSlam(const InertialSlamSettings& settings, std::vector<Camera> cameras,
                           const ImuNoise& noise, const ImuBuffer::Options& imu, double pixel_sigma,
                           const InertialStart& start, std::shared_ptr<const LandmarkMap> prior,
                           bool starts_in_map)
    : context_(initial_context(settings, std::move(cameras), pixel_sigma, start)),
      studies_(settings, context_.now),
      propagator_(settings, noise, imu),
      loops_(loop_settings(context_), context_.cameras, std::move(prior)),
      standstill_(settings, noise, context_.cameras.size(), pixel_sigma),
      tracks_(settings),
      undelayed_(depth_rule(settings.depth_rule)) {
  propagator_.note_prediction(context_.state());
  if (starts_in_map) loops_.start_in_map(context_.filter, context_.clock(context_.now));
}

Estimate InertialSlam::process(const FeatureFrame& frame) {
  StageClock stages;
  propagate(frame);
  const Closing closing = close_loops(frame);
  const double seconds = stages.lap();
  Estimate e = conclude(frame, closing);
  if (e.seconds) e.seconds->propagation = seconds;
  return e;
}

// What a frame does after the search for loops.
Estimate InertialSlam::conclude(const FeatureFrame& frame, const Closing& closing) {
  StageClock stages;
  Estimate e;
  StageSeconds& seconds = e.seconds.emplace();
  e.zero_velocity = standstill_.update(context_, frame, since_);
  augment_clone(frame, e);
  update(frame, closing, e);
  seconds.update = stages.lap();
  retire(frame);
  null_space_update(frame, e);
  initialise_landmarks(e);
  name_outcomes(frame, e);
  seconds.landmarks = stages.lap();
  report(frame, e);
  return e;
}

void InertialSlam::propagate(const FeatureFrame& frame) {
  since_ = frame.time - context_.now;
  without_.reset();
  propagator_.propagate(context_, frame.time);
  ++context_.frame;
  if (studies_.compose_when_due(context_.filter, context_.now)) {
    propagator_.note_prediction(context_.state());
  }
}

// Past landmarks that are in view return before the update of the frame. A copy goes on without
// them.
InertialSlam::Closing InertialSlam::close_loops(const FeatureFrame& frame) {
  const FrameMoment at{
      .frame = context_.frame, .now = context_.now, .by_imu = context_.clock(context_.now)};
  auto found = loops_.search(frame, observations(frame), context_.filter, at);
  if (!found) return {};
  Closing closing{.returned = true};
  if (found->by_appearance()) closing.before = context_.state().world_T_imu;
  without_ = std::make_shared<InertialSlam>(*this);
  without_->loops_.leave_out(*found, without_->context_.filter);
  loops_.close(*found, context_.filter, context_.records, at);
  return closing;
}

// The frame's observations, under the ids of recognised landmarks.
const std::vector<const PixelObservation*>& InertialSlam::observations(const FeatureFrame& frame) {
  return usable_.among(loops_.renamed(frame), context_.cameras.size());
}

// With the noise of the landmarks since the frame before.
void InertialSlam::augment_clone(const FeatureFrame& frame, const Estimate& e) {
  if (!e.zero_velocity) landmarks_.add_drift(context_, since_);
  clones_.augment(context_, frame, e.zero_velocity);
}

void InertialSlam::update(const FeatureFrame& frame, const Closing& closing, Estimate& e) {
  landmarks_.update(context_, observations(frame), closing.returned, studies_, e);
  if (closing.before) loops_.note_change(*closing.before, context_.state().world_T_imu);
  if (context_.settings.init == LandmarkInit::kFixedDepth) {
    e.added += undelayed_.initialise(context_, landmarks_.fresh());
    return;
  }
  for (const PixelObservation* o : landmarks_.fresh()) {
    if (!loops_.awaits(o->landmark)) tracks_.add(context_, *o, clones_.augmented());
  }
}

void InertialSlam::retire(const FeatureFrame& frame) {
  landmarks_.make_cartesian(context_);
  const std::vector<int>& leaving = landmarks_.find_leaving(context_, observing(frame));
  loops_.note_leaving(leaving, context_.filter, context_.records, context_.now);
  remove(context_.records, leaving);
  context_.filter.retire(leaving);
  loops_.bar_others(context_.filter);
}

// Tracks whose depth is now determined become landmarks on the way.
void InertialSlam::null_space_update(const FeatureFrame& frame, Estimate& e) {
  if (context_.settings.init != LandmarkInit::kMultiView) return;
  e.added += tracks_.update(context_, observing(frame), clones_);
}

void InertialSlam::initialise_landmarks(Estimate& e) {
  if (clones_.augmented()) {
    if (clones_.full(context_.settings)) clones_.drop_oldest();
    e.added += tracks_.initialise_missing(context_, undelayed_);
  }
  clones_.remove_unused(context_, tracks_.tracks(), standstill_.clone());
}

// The outcomes are those of the frame's observations, under the ids of their tracks.
void InertialSlam::name_outcomes(const FeatureFrame& frame, const Estimate& e) {
  landmarks_.note_initialised(context_, e.added);
  landmarks_.name_outcomes(usable_.last(),
                           [&](const PixelObservation& o) { return loops_.original(frame, o); });
}

void InertialSlam::report(const FeatureFrame& frame, Estimate& e) {
  const Ekf& filter = context_.filter;
  e.time = clock(frame.time);
  const NavState now = propagator_.motion(context_);
  e.world_T_imu = now.nav_T_imu;
  e.v_world = now.v_nav;
  e.additive = now.biases;
  e.covariance = now.covariance;
  e.calibration = calibration_of(filter);
  e.scale_sigma = filter.scale_sigma();
  e.observations = static_cast<int>(frame.pixels.size());
  e.in_state = static_cast<int>(filter.state().landmarks.size());
  e.landmarks = filter.past().map_size();
  e.tracks = tracks_.use(context_);
  const Eigen::MatrixXd& derivative = propagator_.motion_derivative();
  if (context_.settings.keeps_exact_map()) {
    context_.filter.remember_pose(e.time, e.world_T_imu, derivative.topRows<6>());
  }
  if (loops_.placed()) e.in_map = loops_.placed()->pose_in_map(filter, now, derivative);
  health_.assess(e, context_.has_sane_clock());
}

Past::Estimates InertialSlam::past_nav() const {
  Past::Estimates past = filter().past().estimates();
  const auto& nav_T_world = context_.state().nav_T_world;
  if (keeps_past(context_.settings) || !nav_T_world) return past;
  for (MapLandmark& landmark : past.landmarks) {
    landmark.p_world = *nav_T_world * landmark.p_world;
    landmark.covariance = nav_T_world->R * landmark.covariance * nav_T_world->R.transpose();
  }
  return past;
}

LandmarkMap InertialSlam::landmark_map(std::optional<Time> until) const {
  return loops_.landmark_map(filter(), clock(context_.now), until);
}

}  // namespace chasles
