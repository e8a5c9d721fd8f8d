#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

#include <chasles/base/error.hpp>
#include <chasles/base/stage_clock.hpp>
#include <chasles/base/validate.hpp>
#include <chasles/eval/chi2.hpp>
#include <chasles/velocity/velocity_model.hpp>
#include <chasles/velocity/velocity_slam.hpp>

namespace chasles {
namespace {

// Mapping takes the predicted trajectory as the truth.
VelocitySlamNoise noise_of(const VelocitySlamSettings& s, VelocitySlamNoise noise) {
  if (s.mode == SlamMode::kMap) noise.motion = {};
  return noise;
}

double gate_of(double probability, StereoRows rows) {
  const int dof = rows == StereoRows::kAll ? 4 : rows == StereoRows::kMean ? 2 : 3;
  return probability < 1 ? chi2_quantile(probability, dof)
                         : std::numeric_limits<double>::infinity();
}

State initial_state(const BodyVelocityModel& model) {
  State x;
  x.additive = Eigen::VectorXd::Zero(model.size());
  return x;
}

// The mean of an unknown velocity is arbitrary. It is set to the first sample, so that level axes
// are linearised at a velocity that is about right.
Prediction start_at(const State& x, const BodyVelocity& u) {
  const int n = x.core_size();
  Prediction begin{.world_T_imu = x.world_T_imu,
                   .v_world = x.v_world,
                   .additive = x.additive,
                   .F = Eigen::MatrixXd::Identity(n, n),
                   .Q = Eigen::MatrixXd::Zero(n, n)};
  begin.additive.head<6>() << u.angular_imu, u.linear_imu;
  return begin;
}

}  // namespace

VelocitySlam::VelocitySlam(const VelocitySlamSettings& settings, const StereoRig& rig,
                           const VelocitySlamNoise& noise)
    : settings_(validated(settings)),
      rig_(rig),
      noise_(noise_of(settings, noise)),
      model_(model_of(settings, noise)),
      rows_(settings.stereo_rows),
      gate_(gate_of(settings.gate, rows_)),
      loose_gate_(gate_of(settings.loose_gate, rows_)),
      filter_(error_chart(settings.chart), initial_state(model_),
              initial_covariance(settings, noise_),
              {.map = settings.compress_map ? Ekf::Map::kHistory : Ekf::Map::kDense,
               .map_bytes = static_cast<std::size_t>(1e6 * settings.map_memory)}) {}

std::vector<std::string> VelocitySlam::additive_names() const {
  return chasles::additive_names(model_);
}

// One frame of the algorithm: update with known landmarks, retire unseen ones, initialise new ones.
Estimate VelocitySlam::process(const FeatureFrame& frame) {
  StageClock clock;
  advance_to(frame.time, velocity_.value_or(BodyVelocity{}));
  ++frame_;
  Estimate estimate;
  estimate.seconds = {.propagation = std::exchange(propagation_seconds_, 0) + clock.lap()};
  estimate.time = frame.time;
  if (settings_.mode != SlamMode::kLocalize) see(frame, estimate);

  const State& x = filter_.state();
  const Eigen::MatrixXd P = filter_.core_covariance();
  estimate.world_T_imu = x.world_T_imu;
  estimate.additive = x.additive;
  estimate.covariance = P;
  estimate.observations = static_cast<int>(frame.observations.size());
  estimate.in_state = static_cast<int>(x.landmarks.size());
  estimate.landmarks = filter_.map_size();
  filter_.remember_pose(frame.time);
  assess(estimate);
  return estimate;
}

void VelocitySlam::see(const FeatureFrame& frame, Estimate& estimate) {
  StageClock clock;
  const Observations observations = usable(frame);
  Matched matched = match(observations);
  if (settings_.update_with_first_observation) {
    estimate.added = initialise(matched.fresh);
    matched = match(observations);
  }
  estimate.rejected = drop_outliers(matched.known);
  choose(matched.known);
  estimate.used = static_cast<int>(matched.known.size());
  if (sample_) matched.known.push_back(*std::exchange(sample_, std::nullopt));
  const UpdateReport report = filter_.update(matched.known);
  estimate.nis = report.nis;
  estimate.nis_dof = report.dof;
  estimate.seconds->update = clock.lap();
  retire_unseen();
  // After the update: an observation either initialises a landmark or updates the state, never
  // both.
  if (!settings_.update_with_first_observation) estimate.added = initialise(matched.fresh);
  estimate.seconds->landmarks = clock.lap();
}

void VelocitySlam::process(const BodyVelocity& u) {
  if (!u.linear_imu.allFinite() || !u.angular_imu.allFinite()) {
    throw InputError("the velocity at " + std::to_string(u.time.count()) + " ns is not finite");
  }
  StageClock clock;
  const bool first = !now_;
  const BodyVelocity before = velocity_.value_or(u);
  advance_to(u.time, held_velocity(settings_, before, u));
  velocity_ = u;
  if (model_.velocity_state) {
    use_sample();
    if (first && model_.level) filter_.propagate(start_at(filter_.state(), u));
    const Measurement z =
        measure_velocity(model_, filter_.state(), u, sample_noise(settings_, noise_.motion, u));
    if (z.residual.allFinite()) sample_ = z;
  }
  propagation_seconds_ += clock.lap();
}

// A velocity waits for a frame of the same time, so that both make one update.
void VelocitySlam::use_sample() {
  if (!sample_) return;
  const Measurement z[] = {*std::exchange(sample_, std::nullopt)};
  filter_.update(z);
}

void VelocitySlam::advance_to(Time time, const BodyVelocity& held) {
  if (now_ && time < *now_) {
    throw InputError("time runs backwards: " + std::to_string(time.count()) + " ns after " +
                     std::to_string(now_->count()) + " ns");
  }
  const double tau = now_ ? to_seconds(time - *now_) : 0;
  if (tau > 0) use_sample();
  if (tau > 0) filter_.propagate(predict(model_, filter_.state(), held, tau, noise_.motion));
  now_ = time;
}

VelocitySlam::Observations VelocitySlam::usable(const FeatureFrame& frame) const {
  Observations result;
  std::unordered_set<LandmarkId> seen;
  for (const StereoObservation& o : frame.observations) {
    if (o.pixels.allFinite() && seen.insert(o.landmark).second) result.push_back(&o);
  }
  return result;
}

VelocitySlam::Matched VelocitySlam::match(const Observations& observations) {
  std::unordered_map<LandmarkId, int> index;
  for (const Landmark& landmark : filter_.state().landmarks) {
    index.emplace(landmark.id, static_cast<int>(index.size()));
  }
  Matched result;
  for (const StereoObservation* o : observations) {
    const auto known = index.find(o->landmark);
    if (known == index.end()) {
      result.fresh.push_back(o);
      continue;
    }
    last_[o->landmark].seen = frame_;
    if (auto z = measure_stereo(rig_, rows_, noise_.update, filter_.state(), known->second, *o)) {
      result.known.push_back(*z);
    }
  }
  return result;
}

// With many landmarks in view, the strict gate drops the worst; with few, the loose gate keeps
// most.
int VelocitySlam::drop_outliers(std::vector<Measurement>& measurements) const {
  const std::vector<double> squares =
      filter_.normalised_squares(measurements, sample_ ? &*sample_ : nullptr);
  const auto inside = [&](double gate) {
    return std::count_if(squares.begin(), squares.end(), [&](double s) { return s < gate; });
  };
  const double gate = inside(gate_) >= settings_.gate_quorum ? gate_ : loose_gate_;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < squares.size(); ++i) {
    if (squares[i] < gate) measurements[kept++] = measurements[i];
  }
  measurements.resize(kept);
  return static_cast<int>(squares.size() - kept);
}

// If more landmarks are in view than a frame may use, those used longest ago come first.
void VelocitySlam::choose(std::vector<Measurement>& measurements) {
  const auto landmark = [&](const Measurement& z) -> const Landmark& {
    return filter_.state().landmarks[static_cast<std::size_t>(z.landmark)];
  };
  const auto budget = static_cast<std::size_t>(settings_.updates_per_frame);
  if (budget > 0 && measurements.size() > budget) {
    std::vector<std::tuple<int, int, std::size_t>> turns;  // last used, how often used, index
    for (const Measurement& z : measurements) {
      turns.emplace_back(last_.at(landmark(z).id).used, landmark(z).observations, turns.size());
    }
    std::sort(turns.begin(), turns.end());
    turns.resize(budget);
    std::vector<Measurement> chosen;
    for (const auto& turn : turns) chosen.push_back(measurements[std::get<2>(turn)]);
    measurements = std::move(chosen);
  }
  for (const Measurement& z : measurements) last_.at(landmark(z).id).used = frame_;
}

int VelocitySlam::initialise(const Observations& fresh) {
  std::vector<NewLandmark> landmarks;
  for (const StereoObservation* o : fresh) {
    if (o->pixels[0] - o->pixels[2] < settings_.min_disparity) continue;
    auto landmark = initialise_landmark(rig_, noise_.initialisation, filter_.state(), *o);
    if (!landmark) continue;
    if (settings_.initial_landmark_sigma) {
      const double sigma = *settings_.initial_landmark_sigma;
      landmark->d_pose.setZero();
      landmark->noise = sigma * sigma * Eigen::Matrix3d::Identity();
    }
    last_[o->landmark] = {.seen = frame_, .used = frame_};
    landmarks.push_back(*landmark);
  }
  filter_.add(landmarks);
  const auto all = static_cast<int>(filter_.state().landmarks.size());
  const auto added = static_cast<int>(landmarks.size());
  for (int i = all - added; i < all; ++i) initial_.push_back(filter_.landmark(i));
  return added;
}

void VelocitySlam::retire_unseen() {
  const std::vector<Landmark>& landmarks = filter_.state().landmarks;
  const int excess = static_cast<int>(landmarks.size()) - settings_.waiting_landmarks;
  std::vector<std::pair<int, int>> unseen;  // (last seen, index), longest unseen first
  for (int i = 0; i < static_cast<int>(landmarks.size()); ++i) {
    const int seen = last_.at(landmarks[static_cast<std::size_t>(i)].id).seen;
    if (seen < frame_) unseen.emplace_back(seen, i);
  }
  if (excess <= 0 || unseen.empty()) return;
  std::sort(unseen.begin(), unseen.end());
  unseen.resize(std::min(unseen.size(), static_cast<std::size_t>(excess)));
  std::vector<int> indices;
  for (const auto& [seen, index] : unseen) {
    indices.push_back(index);
    last_.erase(landmarks[static_cast<std::size_t>(index)].id);
  }
  std::sort(indices.begin(), indices.end());
  filter_.retire(indices);
}

void VelocitySlam::assess(Estimate& estimate) {
  if (!estimate.world_T_imu.R.allFinite() || !estimate.world_T_imu.p.allFinite() ||
      !estimate.pose_covariance().allFinite() ||
      estimate.pose_covariance().diagonal().minCoeff() < 0) {
    estimate.health = Health::kLost;
    return;
  }
  if (settings_.mode == SlamMode::kLocalize) return;
  estimate.degradation = recent_.assess(estimate.time, estimate.used, estimate.rejected,
                                        estimate.nis, estimate.nis_dof);
  // The trajectory of a mapping run is exact, whatever number of observations there is.
  const bool mapping = settings_.mode == SlamMode::kMap;
  if (mapping && estimate.degradation != Degradation::kInnovations)
    estimate.degradation = Degradation::kNone;
  if (estimate.degradation != Degradation::kNone) estimate.health = Health::kDegraded;
}

}  // namespace chasles
