#include <algorithm>
#include <limits>
#include <utility>

#include <chasles/filter/pixel_measurement.hpp>
#include <chasles/filter/relinearise.hpp>
#include <chasles/slam/landmark_updater.hpp>

namespace chasles {
namespace {

// Noise may move the inverse depth of a far point below zero. If it is significantly below, the
// rays of the track meet behind the cameras: pixels or motion are wrong.
bool cannot_be(const Ekf& filter, const Landmark& landmark) {
  constexpr double kSigmas = 3;
  return landmark.anchor &&
         landmark.inverse_depth.z() < -kSigmas * filter.inverse_depth_sigma(landmark);
}

}  // namespace

void LandmarkUpdater::add_drift(SlamContext& x, Time since) const {
  const double variance = x.track_noise().drift_variance(to_seconds(since));
  if (variance <= 0) return;
  const auto& landmarks = x.state().landmarks;
  for (int i = 0; i < static_cast<int>(landmarks.size()); ++i) {
    const Landmark& landmark = landmarks[static_cast<std::size_t>(i)];
    x.filter.add_noise(
        i, drift_noise(x.camera(landmark.camera), x.state(), landmark, variance, landmark.camera));
  }
}

void LandmarkUpdater::update(SlamContext& x, const Observations& observations, bool returned,
                             const StudyHooks& studies, Estimate& e) {
  linearise(x, observations, studies, e);
  if (returned && !x.settings.uses_first_estimates()) relinearise(x);
  const UpdateReport& report = x.filter.update(known_);
  e.nis = report.nis;
  e.nis_dof = report.dof;
  e.used = static_cast<int>(std::count(report.accepted.begin(), report.accepted.end(), true));
  e.rejected += static_cast<int>(known_.size()) - e.used;
  note_report(x, report);
  correlation_.add(predicted_, report, e);
}

// Fills the measurements of known landmarks, and the list of fresh observations.
void LandmarkUpdater::linearise(SlamContext& x, const Observations& observations,
                                const StudyHooks& studies, Estimate& e) {
  index_.set(x.state());
  known_.clear();
  predicted_.clear();
  fresh_.clear();
  outcomes_.clear();
  of_outcome_.clear();
  const double gate = x.gate_square(2);
  for (const PixelObservation* o : observations) {
    outcomes_.push_back({.observation = *o});
    const auto landmark = index_.find(o->landmark);
    if (!landmark) {
      fresh_.push_back(o);
      continue;
    }
    LandmarkRecord& record = x.records[static_cast<std::size_t>(*landmark)];
    record.seen = x.frame;
    record.cameras |= following(*o);
    if (e.zero_velocity) continue;
    outcomes_.back().outcome = Outcome::kRejected;  // until it is used
    Measurement& z = known_.append();
    if (!measure(x, *o, *landmark, studies, z)) {
      known_.remove_last();
      ++record.rejected;
      ++e.rejected;
      continue;
    }
    z.gate = gate;
    z.shared_variance = x.shared_variance();
    predicted_.push_back(o);
    of_outcome_.push_back(outcomes_.size() - 1);
  }
}

// False where the landmark is not visible at its estimated position, or has none.
bool LandmarkUpdater::measure(const SlamContext& x, const PixelObservation& o, int index,
                              const StudyHooks& studies, Measurement& z) const {
  const Landmark& landmark = x.state().landmarks[static_cast<std::size_t>(index)];
  if (cannot_be(x.filter, landmark)) return false;
  const Camera& camera = x.camera(o.camera);
  const TrackNoise noise = x.track_noise();
  if (!measure_pixel(camera, noise.sigma * studies.noise_inflation(landmark), x.state(), index,
                     o.pixel, x.linearisation(), o.camera, z)) {
    return false;
  }
  studies.differentiate(x.filter, camera, z);
  if (o.is_match()) {
    const int matches = x.records[static_cast<std::size_t>(index)].matches;
    z.noise += noise.match_variance(matches + 1) * Eigen::Matrix2d::Identity();
  }
  // The product of two errors is nearly constant from image to image: all observations together
  // may contain no more information than a few.
  const double repeated =
      std::min<double>(landmark.observations, x.settings.guessed_depth_observations.value_or(0));
  if (repeated > 0) z.noise += repeated * bilinear_noise(camera, x.filter, index, o.camera);
  return true;
}

// The correction of a closure may be larger than one linearisation bears, so the measurements are
// linearised where the update leads, until it leads there.
void LandmarkUpdater::relinearise(const SlamContext& context) {
  constexpr int kMostSteps = 5;
  constexpr double kSameFrom = 0.05;  // change of a residual [px]
  const Ekf& filter = context.filter;
  const State& x = filter.state();
  double change = std::numeric_limits<double>::infinity();
  for (int step = 0; step < kMostSteps && change > kSameFrom; ++step) {
    const std::optional<State> y = filter.updated_mean(known_);
    if (!y) return;
    const Eigen::VectorXd correction = correction_between(filter.chart(), x, *y);
    change = 0;
    for (std::size_t i = 0; i < known_.size(); ++i) {
      const PixelObservation& o = *predicted_[i];
      auto there = measure_pixel(context.camera(o.camera), 1, *y, known_[i].landmark, o.pixel,
                                 context.linearisation(), o.camera);
      if (!there) continue;
      refer_to(filter.chart(), x, *y, correction, *there);
      change = std::max(change, (there->residual - known_[i].residual).norm());
      known_[i].residual = there->residual;
      known_[i].d_core = there->d_core;
      known_[i].d_landmark = there->d_landmark;
      known_[i].clones = std::move(there->clones);
    }
  }
}

// A landmark that is rejected repeatedly has become another point, or was never a point. If the
// pose is wrong instead, new landmarks do not inherit its error.
void LandmarkUpdater::note_report(SlamContext& x, const UpdateReport& report) {
  for (std::size_t i = 0; i < known_.size(); ++i) {
    LandmarkRecord& record = x.records[static_cast<std::size_t>(known_[i].landmark)];
    record.rejected = report.accepted[i] ? 0 : record.rejected + 1;
    PixelOutcome& one = outcomes_[of_outcome_[i]];
    if (report.accepted[i]) {
      one.outcome = Outcome::kUsed;
      record.matches += one.observation.is_match();
    }
    one.expected = {.pixel = one.observation.pixel - known_[i].residual,
                    .covariance = report.covariances[i]};
  }
}

void LandmarkUpdater::make_cartesian(SlamContext& x) const {
  if (x.settings.uses_first_estimates()) return;  // it would change the linearisation point
  const auto& landmarks = x.state().landmarks;
  for (int i = 0; i < static_cast<int>(landmarks.size()); ++i) {
    const Landmark& landmark = landmarks[static_cast<std::size_t>(i)];
    if (!landmark.anchor) continue;
    const double most = x.settings.settled_depth_sigma * landmark.inverse_depth.z();
    if (x.filter.inverse_depth_sigma(landmark) < most) x.filter.make_cartesian(i);
  }
}

const std::vector<int>& LandmarkUpdater::find_leaving(SlamContext& x, CameraSet looking) {
  leaving_.clear();
  for (int i = 0; i < static_cast<int>(x.records.size()); ++i) {
    LandmarkRecord& record = x.records[static_cast<std::size_t>(i)];
    if (record.seen == x.frame) {
      record.missed = 0;
    } else if (is_followed(record.cameras, looking)) {
      ++record.missed;
    }
    const bool accepted = record.rejected < x.settings.max_rejections;
    if (accepted && record.missed <= x.settings.waiting_frames) continue;
    leaving_.push_back(i);
  }
  return leaving_;
}

void LandmarkUpdater::note_initialised(SlamContext& x, int added) {
  const auto& landmarks = x.state().landmarks;
  for (std::size_t i = landmarks.size() - static_cast<std::size_t>(added); i < landmarks.size();
       ++i) {
    for (PixelOutcome& one : outcomes_) {
      if (one.observation.landmark != landmarks[i].id) continue;
      one.outcome = Outcome::kInitialised;
      x.records[i].cameras |= following(one.observation);
    }
  }
}

}  // namespace chasles
