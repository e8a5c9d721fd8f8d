#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

#include <chasles/filter/numeric_derivatives.hpp>
#include <chasles/filter/relinearise.hpp>
#include <chasles/slam/inertial_slam.hpp>

// Updates of the filter with the pixels of a frame, and their innovations.
namespace chasles {

// Of two observations of one landmark in one camera the first counts; the frame's order is kept.
const std::vector<const PixelObservation*>& InertialSlam::usable(
    std::span<const PixelObservation> pixels) {
  auto& places = work_.places;
  places.clear();
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const PixelObservation& o = pixels[i];
    const bool known_camera = o.camera >= 0 && o.camera < static_cast<int>(cameras_.size());
    if (!known_camera || !o.pixel.allFinite()) continue;
    places.push_back({.landmark = o.landmark, .camera = o.camera, .index = i});
  }
  const auto key = [](const auto& p) { return std::tuple(p.landmark, p.camera, p.index); };
  std::sort(places.begin(), places.end(),
            [&](const auto& a, const auto& b) { return key(a) < key(b); });
  const auto same = [](const auto& a, const auto& b) {
    return a.landmark == b.landmark && a.camera == b.camera;
  };
  places.erase(std::unique(places.begin(), places.end(), same), places.end());
  std::sort(places.begin(), places.end(),
            [](const auto& a, const auto& b) { return a.index < b.index; });
  work_.usable.clear();
  for (const auto& place : places) work_.usable.push_back(&pixels[place.index]);
  return work_.usable;
}

void InertialSlam::number_landmarks() {
  work_.numbers.clear();
  for (const Landmark& landmark : filter_.state().landmarks) {
    work_.numbers.emplace_back(landmark.id, static_cast<int>(work_.numbers.size()));
  }
  std::sort(work_.numbers.begin(), work_.numbers.end());
}

std::optional<int> InertialSlam::number_of(LandmarkId id) const {
  const auto found = std::lower_bound(work_.numbers.begin(), work_.numbers.end(), std::pair(id, 0));
  if (found == work_.numbers.end() || found->first != id) return std::nullopt;
  return found->second;
}

// During a standstill the same patch is seen from the same place: nothing slides.
void InertialSlam::let_points_drift(Time since) {
  const double variance = track_noise().drift_variance(to_seconds(since));
  if (variance <= 0) return;
  const auto& landmarks = filter_.state().landmarks;
  for (int i = 0; i < static_cast<int>(landmarks.size()); ++i) {
    const Landmark& landmark = landmarks[static_cast<std::size_t>(i)];
    const Camera& camera = cameras_[static_cast<std::size_t>(landmark.camera)];
    filter_.add_noise(i, drift_noise(camera, filter_.state(), landmark, variance, landmark.camera));
  }
}

// The first linearisations are the worst, so they get more noise (docs/derivations.md, D50).
double InertialSlam::noise_inflation(int landmark) const {
  if (settings_.noise_inflation <= 0 || settings_.noise_inflation_frames <= 0) return 1;
  const auto& l = filter_.state().landmarks[static_cast<std::size_t>(landmark)];
  const double age = static_cast<double>(l.observations) / settings_.noise_inflation_frames;
  return 1 + settings_.noise_inflation * std::max(0.0, 1 - age);
}

// Noise may move the inverse depth of a far point below zero. If it is significantly below, the
// rays of the track meet behind the cameras: pixels or motion are wrong.
bool InertialSlam::cannot_be(const Landmark& landmark) const {
  constexpr double kSigmas = 3;
  return landmark.anchor &&
         landmark.inverse_depth.z() < -kSigmas * filter_.inverse_depth_sigma(landmark);
}

// During a standstill a pixel has the same error in every image: its observations are one, not
// many, and the zero-velocity update contains more information.
void InertialSlam::observe(const std::vector<const PixelObservation*>& observations, bool returned,
                           Estimate& e) {
  number_landmarks();
  auto& known = work_.known;
  auto& predicted = work_.predicted;
  auto& fresh = work_.fresh;
  known.clear();
  predicted.clear();
  fresh.clear();
  outcomes_.clear();
  work_.assessed.clear();
  const double gate = gate_square(2);
  int rejected = 0;
  for (const PixelObservation* o : observations) {
    outcomes_.push_back({.observation = *o});
    const auto number = number_of(o->landmark);
    if (!number) {
      fresh.push_back(o);
      continue;
    }
    Last& last = last_[static_cast<std::size_t>(*number)];
    last.seen = frame_;
    last.cameras |= camera_bit(o->camera);
    if (e.zero_velocity) continue;
    outcomes_.back().outcome = Outcome::kRejected;  // until it is used
    const Landmark& landmark = filter_.state().landmarks[static_cast<std::size_t>(*number)];
    if (cannot_be(landmark)) {
      ++last.rejected;
      ++rejected;
      continue;
    }
    const Camera& camera = cameras_[static_cast<std::size_t>(o->camera)];
    Measurement& z = known.append();
    if (!measure_pixel(camera, track_noise().sigma * noise_inflation(*number), filter_.state(),
                       *number, o->pixel, linearisation(), o->camera, z)) {
      known.remove_last();  // at its estimated position it is not visible
      ++last.rejected;
      ++rejected;
      continue;
    }
    if (settings_.numeric_jacobians) {
      differentiate_numerically(filter_.chart(), camera, filter_.state(), z);
    }
    if (TrackNoise::is_match(o->camera)) {
      z.noise += track_noise().match_variance(last.matches + 1) * Eigen::Matrix2d::Identity();
    }
    // The product of two errors is nearly constant from image to image: all observations together
    // may contain no more information than a few.
    const double repeated =
        std::min<double>(landmark.observations, settings_.guessed_depth_observations.value_or(0));
    if (repeated > 0) z.noise += repeated * bilinear_noise(camera, filter_, *number, o->camera);
    z.gate = gate;
    z.shared_variance = shared_variance();
    predicted.push_back(o);
    work_.assessed.push_back(outcomes_.size() - 1);
  }
  if (returned && !settings_.first_estimates) relinearise(predicted, known);
  const UpdateReport& report = filter_.update(known);
  e.nis = report.nis;
  e.nis_dof = report.dof;
  e.used = static_cast<int>(std::count(report.accepted.begin(), report.accepted.end(), true));
  e.rejected = rejected + static_cast<int>(known.size()) - e.used;
  note_rejections(known, report.accepted);
  note_outcomes(known, report);
  compare_innovations(predicted, report, e);
  if (settings_.init == LandmarkInit::kFixedDepth) {
    initialise_fresh(fresh, e);
    return;
  }
  for (const PixelObservation* o : fresh) {
    if (settings_.recognise == Recognise::kIds && inactive_.contains(o->landmark)) {
      continue;  // it will return
    }
    Track& track = track_of(o->landmark);
    track.seen = frame_;
    track.cameras |= camera_bit(o->camera);
    if (cloned_) {
      track.views.push_back({.clone = frame_, .camera = o->camera, .pixel = o->pixel});
    }
  }
}

// The correction of a closure may be larger than one linearisation bears, so the measurements are
// linearised where the update leads, until it leads there.
void InertialSlam::relinearise(const std::vector<const PixelObservation*>& predicted,
                               std::span<Measurement> known) const {
  constexpr int kMostSteps = 5;
  constexpr double kSameFrom = 0.05;  // change of a residual [px]
  const State& x = filter_.state();
  double change = std::numeric_limits<double>::infinity();
  for (int step = 0; step < kMostSteps && change > kSameFrom; ++step) {
    const std::optional<State> y = filter_.updated_mean(known);
    if (!y) return;
    const Eigen::VectorXd correction = correction_between(filter_.chart(), x, *y);
    change = 0;
    for (std::size_t i = 0; i < known.size(); ++i) {
      const PixelObservation& o = *predicted[i];
      auto there = measure_pixel(cameras_[static_cast<std::size_t>(o.camera)], 1, *y,
                                 known[i].landmark, o.pixel, linearisation(), o.camera);
      if (!there) continue;
      refer_to(filter_.chart(), x, *y, correction, *there);
      change = std::max(change, (there->residual - known[i].residual).norm());
      known[i].residual = there->residual;
      known[i].d_core = there->d_core;
      known[i].d_landmark = there->d_landmark;
      known[i].clones = std::move(there->clones);
    }
  }
}

// A landmark that is rejected repeatedly has become another point, or was never a point. If the
// pose is wrong instead, new landmarks do not inherit its error.
void InertialSlam::note_rejections(std::span<const Measurement> known,
                                   const std::vector<bool>& accepted) {
  for (std::size_t i = 0; i < known.size(); ++i) {
    int& rejected = last_[static_cast<std::size_t>(known[i].landmark)].rejected;
    rejected = accepted[i] ? 0 : rejected + 1;
  }
}

void InertialSlam::note_outcomes(std::span<const Measurement> known, const UpdateReport& report) {
  for (std::size_t i = 0; i < known.size(); ++i) {
    PixelOutcome& assessed = outcomes_[work_.assessed[i]];
    if (report.accepted[i]) {
      assessed.outcome = Outcome::kUsed;
      Last& last = last_[static_cast<std::size_t>(known[i].landmark)];
      last.matches += TrackNoise::is_match(assessed.observation.camera);
    }
    assessed.expected = {.pixel = assessed.observation.pixel - known[i].residual,
                         .covariance = report.covariances[i]};
  }
}

// The landmarks that the frame has added are the last ones of the state.
void InertialSlam::note_initialised(int added) {
  const auto& landmarks = filter_.state().landmarks;
  for (std::size_t i = landmarks.size() - static_cast<std::size_t>(added); i < landmarks.size();
       ++i) {
    for (PixelOutcome& assessed : outcomes_) {
      if (assessed.observation.landmark != landmarks[i].id) continue;
      assessed.outcome = Outcome::kInitialised;
      last_[i].cameras |= camera_bit(assessed.observation.camera);
    }
  }
}

void InertialSlam::compare_innovations(const std::vector<const PixelObservation*>& observations,
                                       const UpdateReport& report, Estimate& e) {
  const auto by_key = [](const WhitenedPixel& a, const WhitenedPixel& b) {
    return std::tie(a.landmark, a.camera) < std::tie(b.landmark, b.camera);
  };
  work_.innovations.clear();
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!report.accepted[i]) continue;
    const Eigen::Vector2d w = report.whitened[i];
    const WhitenedPixel now{
        .landmark = observations[i]->landmark, .camera = observations[i]->camera, .innovation = w};
    work_.innovations.push_back(now);
    const auto before = std::lower_bound(innovations_.begin(), innovations_.end(), now, by_key);
    if (before == innovations_.end() || by_key(now, *before)) continue;
    e.innovation_products += w.dot(before->innovation);
    e.innovation_squares += (w.squaredNorm() + before->innovation.squaredNorm()) / 2;
  }
  std::sort(work_.innovations.begin(), work_.innovations.end(), by_key);
  innovations_.swap(work_.innovations);
}

}  // namespace chasles
