#include <algorithm>
#include <cmath>
#include <limits>

#include <chasles/eval/chi2.hpp>
#include <chasles/slam/slam_context.hpp>

namespace chasles {
namespace {

// Pixels do not determine a larger time offset [s].
constexpr double kLongestTimeOffset = 0.5;

}  // namespace

double SlamContext::time_offset() const {
  return filter.state().time_offset.value_or(settings.initial_time_offset());
}

bool SlamContext::has_sane_clock() const { return std::abs(time_offset()) <= kLongestTimeOffset; }

Time SlamContext::clock(Time of_cameras) const {
  return has_sane_clock() ? of_cameras + from_seconds(time_offset()) : of_cameras;
}

Linearisation SlamContext::linearisation() const {
  return settings.uses_first_estimates() ? Linearisation::kFirstEstimates : Linearisation::kCurrent;
}

TrackNoise SlamContext::track_noise() const {
  return {.sigma = settings.track_sigma.value_or(pixel_sigma),
          .drift = settings.track_drift.value_or(0),
          .match = settings.match_sigma.value_or(0)};
}

double SlamContext::gate_square(int dof) const {
  if (!(settings.gate < 1)) return std::numeric_limits<double>::max();
  const auto index = static_cast<std::size_t>(dof);
  if (index >= gate_squares.size()) gate_squares.resize(index + 1);
  double& square = gate_squares[index];
  if (square == 0) square = chi2_quantile(settings.gate, dof);
  return square;
}

double SlamContext::shared_variance() const {
  const double sigma = track_noise().sigma;
  return std::max(0.0, sigma * sigma - pixel_sigma * pixel_sigma);
}

void SlamContext::keep_pose(Time time) {
  const auto& clones = filter.state().clones;
  const bool there = !clones.empty() && clones.back().id == frame;
  if (!there) filter.clone_pose(frame, time);
}

int SlamContext::add(const Reused<NewLandmark>& landmarks) {
  filter.add(landmarks);
  for (const NewLandmark& landmark : landmarks) {
    records.push_back({.seen = frame, .matches = landmark.matches});
  }
  return static_cast<int>(landmarks.size());
}

}  // namespace chasles
