#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <chasles/eval/chi2.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/slam/inertial_calibration.hpp>
#include <chasles/slam/inertial_slam.hpp>
#include <chasles/slam/start_covariance.hpp>
#include <chasles/base/stage_clock.hpp>
#include <chasles/base/validate.hpp>

namespace chasles {
namespace {

ImuBuffer::Options with_vibration(ImuBuffer::Options imu, const InertialSlamSettings& s) {
  imu.vibration_noise = s.vibration_noise.value_or(0);
  return imu;
}

State initial_state(const InertialSlamSettings& s, const InertialStart& start,
                    const std::optional<Calibration>& calibration) {
  State x;
  if (calibration) {
    x.imu_T_camera = calibration->imu_T_camera;
    x.time_offset = calibration->time_offset;
  }
  x.additive.resize(InertialModel::kSize);
  x.additive << start.accelerometer_bias, start.gyroscope_bias;
  if (s.nav_attitude) {
    x.nav_T_world = start.nav_T_imu;
    x.v_world = start.nav_T_imu.R.transpose() * start.v_nav;
  } else {
    x.world_T_imu = start.nav_T_imu;
    x.v_world = start.v_nav;
  }
  return x;
}

// From errors in nav to those of the state's core.
Eigen::MatrixXd initial_covariance(const InertialSlamSettings& s, const InertialStart& start,
                                   const State& x, const std::optional<Calibration>& calibration) {
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(x.core_size(), 15);
  J.block<3, 3>(x.nav_T_world ? x.nav_row() : 0, 0).setIdentity();
  J.block<3, 3>(x.nav_T_world ? x.nav_row() + 3 : 3, 3).setIdentity();
  J.block<3, 3>(6, 6).setIdentity();
  J.block<6, 6>(x.additive_row(), 9).setIdentity();
  if (x.nav_T_world) {  // v_world = R^T v_nav, R = Exp(psi) Rhat
    const Eigen::Matrix3d& R = x.nav_T_world->R;
    J.block<3, 3>(6, 6) = R.transpose();
    J.block<3, 3>(6, 0) = R.transpose() * hat(start.v_nav);
  }
  Eigen::MatrixXd P = dense::product(J, dense::product(start_covariance(s, start), J.transpose()));
  const int n = x.calibration_size();
  if (calibration) P.bottomRightCorner(n, n) = calibration->covariance;
  return P;
}

bool keeps_past(const InertialSlamSettings& s) {
  return s.keeps_exact_map() || s.recognise != Recognise::kNone;
}

Ekf initial_filter(const InertialSlamSettings& s, const InertialStart& start,
                   std::span<const Camera> cameras) {
  const auto calibration = start.calibration ? start.calibration : stated_calibration(s, cameras);
  const State x = initial_state(s, start, calibration);
  return {error_chart(s.chart),
          x,
          initial_covariance(s, start, x, calibration),
          {.map = keeps_past(s) ? Ekf::Map::kPast : Ekf::Map::kFrozen,
           .past = {.recalls = s.recognise != Recognise::kNone,
                    .records = true,
                    .most_bytes = static_cast<std::size_t>(1e6 * s.map_memory)},
           .keep_scale = s.keep_scale == Toggle::kTrue}};
}

// With at most this many landmarks in its state, a filter works mainly with tracks.
constexpr int kFewLandmarks = 4;
constexpr Time kBlind = std::chrono::seconds(1);

std::optional<RecentTracks> recent_tracks(const InertialSlamSettings& s) {
  if (s.init != LandmarkInit::kMultiView ||
      std::max(s.max_landmarks, s.min_landmarks) >= kFewLandmarks) {
    return std::nullopt;
  }
  return RecentTracks(s.frames_per_clone, (s.clones + 1) * s.frames_per_clone);
}

}  // namespace

InertialSlam::InertialSlam(const InertialSlamSettings& settings, std::vector<Camera> cameras,
                           const ImuNoise& noise, const ImuBuffer::Options& imu, double pixel_sigma,
                           const InertialStart& start, std::shared_ptr<const LandmarkMap> prior,
                           bool starts_in_map)
    : settings_(validated(settings)),
      cameras_(std::move(cameras)),
      pixel_sigma_(pixel_sigma),
      depth_rule_(depth_rule(settings.depth_rule)),
      model_{
          .noise = scaled(noise, settings.imu_noise_scale.value_or(1)),
          .first_order = settings.first_order_transition ? &error_chart(settings.chart) : nullptr},
      imu_(with_vibration(imu, settings)),
      filter_(initial_filter(settings, start, cameras_)),
      now_(start.time - clock(Time{})),
      composed_(now_),
      recent_tracks_(recent_tracks(settings_)),
      choice_(settings_.recognisable) {
  note_prediction();
  if (prior && settings_.recognise == Recognise::kAppearance) {
    prior_ = Prior{.map = std::move(prior)};
    if (starts_in_map) {
      prior_->place = MapPlace{.world_T_map = {}, .heading_sigma = 0, .position_sigma = 0};
      put_points_in_place();
      place_map();
    }
  }
  if (settings.zupt_velocity_sigma > 0) {
    standstill_.emplace(noise, cameras_.size(), pixel_sigma);
  }
}

Estimate InertialSlam::process(const FeatureFrame& frame) {
  since_ = frame.time - now_;
  without_.reset();
  StageClock stages;
  if (!timed_.empty()) apply_timed(frame.time);
  advance_to(frame.time);
  ++frame_;
  compose_when_due();
  const auto& observations = usable(renamed(frame));
  const SE3 predicted = filter_.state().world_T_imu;
  const bool by_ids = settings_.recognise == Recognise::kIds && revive_ids(observations);
  const bool closes =
      settings_.recognise == Recognise::kAppearance && recognise(frame, observations);
  const double propagation = stages.lap();
  Estimate e = conclude(frame, by_ids || closes, closes ? std::optional(predicted) : std::nullopt);
  if (e.seconds) e.seconds->propagation = propagation;
  return e;
}

// What a frame does after the propagation. `closed_at`: the pose before a closure by appearance.
Estimate InertialSlam::conclude(const FeatureFrame& frame, bool returned,
                                const std::optional<SE3>& closed_at) {
  StageClock stages;
  const CameraSet looking = observing(frame);
  Estimate e;
  StageSeconds& seconds = e.seconds.emplace();
  e.observations = static_cast<int>(frame.pixels.size());
  const auto& observations = usable(renamed(frame));
  e.zero_velocity = zero_velocity_update(frame, since_);
  if (!e.zero_velocity) let_points_drift(since_);
  // During a standstill all poses are the same, and a pixel has the same error in all of them.
  cloned_ = settings_.init == LandmarkInit::kMultiView && is_clone_due(frame) && !e.zero_velocity;
  if (cloned_) {
    keep_pose(frame.time);
    window_.push_back(frame_);
  }
  observe(observations, returned, e);
  if (closed_at) note_change(*closed_at, filter_.state().world_T_imu);
  seconds.update = stages.lap();
  settle();
  retire_unseen(looking);
  if (settings_.init == LandmarkInit::kMultiView) begin_from_tracks(looking, e);
  remove_unused_clones();
  note_begun(e.added);
  name_outcomes(frame, observations);
  seconds.landmarks = stages.lap();

  e.time = clock(frame.time);
  const NavState now = motion();
  e.world_T_imu = now.nav_T_imu;
  e.v_world = now.v_nav;
  e.additive = now.biases;
  e.covariance = now.covariance;
  e.calibration = calibration_of(filter_);
  e.in_state = static_cast<int>(filter_.state().landmarks.size());
  e.landmarks = filter_.map_size();
  e.tracks = use_of_tracks();
  if (settings_.keeps_exact_map()) {
    filter_.remember_pose(e.time, e.world_T_imu, work_.nav.derivative.topRows<6>());
  }
  e.in_map = pose_in_map(now);
  judge(e);
  return e;
}

Past::Estimates InertialSlam::past_nav() const {
  Past::Estimates past = filter_.past_estimates();
  const auto& nav_T_world = filter_.state().nav_T_world;
  if (keeps_past(settings_) || !nav_T_world) return past;
  for (MapLandmark& landmark : past.landmarks) {
    landmark.p_world = *nav_T_world * landmark.p_world;
    landmark.covariance = nav_T_world->R * landmark.covariance * nav_T_world->R.transpose();
  }
  return past;
}

// track_sigma stands for errors that many tracks share. A wrong track is one that differs from the
// others, so the gate judges it by pixel_sigma.
double InertialSlam::shared_variance() const {
  const double sigma = track_noise().sigma;
  return std::max(0.0, sigma * sigma - pixel_sigma_ * pixel_sigma_);
}

// Finite, so that an update computes every squared innovation, with a gate or without.
double InertialSlam::gate_square(int dof) const {
  return settings_.gate < 1 ? chi2_quantile(settings_.gate, dof)
                            : std::numeric_limits<double>::max();
}

// Counts frames during a standstill too. A frame may be a little early for the interval.
bool InertialSlam::is_clone_due(const FeatureFrame& frame) {
  constexpr double kEarly = 0.95;
  if (observing(frame) == 0) return false;
  const bool due = !last_clone_ || ++since_clone_ >= settings_.frames_per_clone ||
                   to_seconds(frame.time - *last_clone_) >= kEarly * settings_.clone_interval;
  if (!due) return false;
  since_clone_ = 0;
  last_clone_ = frame.time;
  return true;
}

// As a clone, at most once per frame.
void InertialSlam::keep_pose(Time time) {
  const auto& clones = filter_.state().clones;
  const bool there = !clones.empty() && clones.back().id == frame_;
  if (!there) filter_.clone_pose(frame_, time);
}

// Whether a zero-velocity update was made. `since`: the time since the last frame.
bool InertialSlam::zero_velocity_update(const FeatureFrame& frame, Time since) {
  if (!standstill_) return false;
  if (!standstill_->detected(frame)) {
    standstill_since_.reset();
    return false;
  }
  if (!standstill_since_ || since <= Time{}) {
    standstill_since_ = frame_;
    keep_pose(frame.time);
    return false;
  }
  const State& x = filter_.state();
  auto& both = work_.rest;
  zero_velocity_measurements(x, x.clone(*standstill_since_), to_seconds(since),
                             settings_.zupt_velocity_sigma, both);
  if (!(filter_.joint_normalised_square(both) < gate_square(9))) return false;
  return !filter_.update(both).failed;
}

// Anchored landmarks with a well-known depth become Cartesian.
void InertialSlam::settle() {
  if (settings_.first_estimates) return;  // it would change the linearisation point
  const auto& landmarks = filter_.state().landmarks;
  for (int i = 0; i < static_cast<int>(landmarks.size()); ++i) {
    const Landmark& landmark = landmarks[static_cast<std::size_t>(i)];
    if (!landmark.anchor) continue;
    const double most = settings_.settled_depth_sigma * landmark.inverse_depth.z();
    if (filter_.inverse_depth_sigma(landmark) < most) {
      filter_.make_cartesian(i);
    }
  }
}

// A landmark out of view ages in the frames whose images might have shown it.
void InertialSlam::retire_unseen(CameraSet looking) {
  std::vector<int>& indices = work_.retired;
  indices.clear();
  const auto& landmarks = filter_.state().landmarks;
  for (int i = 0; i < static_cast<int>(landmarks.size()); ++i) {
    Last& last = last_[static_cast<std::size_t>(i)];
    if (last.seen == frame_) {
      last.missed = 0;
    } else if ((last.cameras & looking) != 0) {
      ++last.missed;
    }
    const bool accepted = last.rejected < settings_.max_rejections;
    if (accepted && last.missed <= settings_.waiting_frames) continue;
    indices.push_back(i);
  }
  note_dormant(indices);
  for (auto i = indices.rbegin(); i != indices.rend(); ++i) last_.erase(last_.begin() + *i);
  filter_.retire(indices);
  filter_.forget(work_.forgotten);
  bound_considered();
}

void InertialSlam::remove_unused_clones() {
  std::vector<int>&used = work_.used, &unused = work_.unused;
  used.clear();
  unused.clear();
  for (const Landmark& landmark : filter_.state().landmarks) {
    if (landmark.anchor) used.push_back(*landmark.anchor);
  }
  if (standstill_since_) used.push_back(*standstill_since_);
  for (const Track& track : tracks_) {
    for (const ClonedView& view : track.views) used.push_back(view.clone);
  }
  std::sort(used.begin(), used.end());
  for (const Clone& clone : filter_.state().clones) {
    if (!std::binary_search(used.begin(), used.end(), clone.id)) unused.push_back(clone.id);
  }
  filter_.remove_clones(unused);
}

// After a second without observations, and for the first second with them again: the drift is
// corrected only when the new observations have determined the velocity.
bool InertialSlam::was_blind(Time time, bool sees) {
  if (!last_seen_) last_seen_ = time;
  const bool blind = time - *last_seen_ > kBlind;
  if (sees) {
    if (blind) regained_ = time;
    last_seen_ = time;
  }
  return blind || (regained_ && time - *regained_ < kBlind);
}

void InertialSlam::judge(Estimate& e) {
  const SE3& pose = e.world_T_imu;
  if (!has_sane_clock() || !pose.R.allFinite() || !pose.p.allFinite() || !e.v_world->allFinite() ||
      !e.covariance.allFinite() || e.covariance.diagonal().minCoeff() < -1e-9) {
    e.health = Health::kLost;
    return;
  }
  const int used = e.used + e.tracks.used;
  const bool few = used + e.tracks.waiting < 3;
  const bool starves = !e.zero_velocity && (few || e.rejected + e.tracks.rejected > used);
  starved_ = starves ? starved_ + 1 : 0;
  const bool contradict = recent_innovations_.contradict(e.time, e.nis, e.nis_dof);
  if (was_blind(e.time, !few || e.zero_velocity)) {
    e.doubt = Doubt::kFewObservations;
  } else if (starved_ > 10) {
    e.doubt = few ? Doubt::kFewObservations : Doubt::kRejections;
  } else if (contradict) {
    e.doubt = Doubt::kInnovations;
  }
  if (e.doubt != Doubt::kNone) e.health = Health::kDegraded;
}

}  // namespace chasles
