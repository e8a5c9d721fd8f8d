#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include <chasles/initialise/static_conditions.hpp>
#include <chasles/initialise/static_start.hpp>

namespace chasles {
namespace {

constexpr double kMedianOfRayleigh = 1.1774;  // of the length of a two-dimensional normal vector
constexpr double kFullWindow = 0.95;

void collect_observations(std::span<const FeatureFrame> frames, std::size_t cameras,
                          StandstillScratch& s) {
  s.observations.clear();
  s.frames.assign(cameras, 0);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::size_t half = 2 * i < frames.size() ? 0 : 1;
    for (const PixelObservation& o : frames[i].pixels) {
      if (!o.pixel.allFinite() || o.camera < 0 || std::cmp_greater_equal(o.camera, cameras)) {
        continue;
      }
      s.observations.push_back({.landmark = o.landmark,
                                .camera = o.camera,
                                .order = s.observations.size(),
                                .half = half,
                                .pixel = o.pixel});
    }
    const CameraSet looking = observing(frames[i]);
    for (std::size_t c = 0; c < cameras; ++c) {
      s.frames[c] += (looking & camera_bit(static_cast<int>(c))) != 0 ? 1 : 0;
    }
  }
  std::ranges::sort(s.observations, [](const StandstillScratch::Observation& a,
                                       const StandstillScratch::Observation& b) {
    return std::tie(a.landmark, a.camera, a.order) < std::tie(b.landmark, b.camera, b.order);
  });
}

// Displacement of each track between the halves of the window, into the scratch. Returns the median
// that noise alone would cause [px].
double find_displacements(std::span<const FeatureFrame> frames, std::size_t cameras,
                          double pixel_sigma, StandstillScratch& s) {
  collect_observations(frames, cameras, s);
  s.pixels.clear();
  double variance = 0;
  for (auto each = s.observations.begin(); each != s.observations.end();) {
    const StandstillScratch::Observation& first = *each;
    Eigen::Vector2d sum[2] = {Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
    int count[2] = {0, 0};
    for (; each != s.observations.end() && each->landmark == first.landmark &&
           each->camera == first.camera;
         ++each) {
      sum[each->half] += each->pixel;
      ++count[each->half];
    }
    const int of_camera = s.frames[static_cast<std::size_t>(first.camera)];
    if (2 * (count[0] + count[1]) < of_camera) continue;
    if (count[0] == 0 || count[1] == 0) continue;
    s.pixels.push_back((sum[1] / count[1] - sum[0] / count[0]).norm());
    variance += 1.0 / count[0] + 1.0 / count[1];
  }
  if (s.pixels.empty()) return 0;
  variance /= static_cast<double>(s.pixels.size());
  return kMedianOfRayleigh * pixel_sigma * std::sqrt(variance);
}

// Of values whose order does not matter.
double median(std::vector<double>& values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace

const std::vector<Requirement>& static_conditions(std::span<const ImuSample> samples,
                                                  std::span<const FeatureFrame> frames,
                                                  std::size_t cameras, const ImuNoise& noise,
                                                  double pixel_sigma, const InitialiserSettings& s,
                                                  StandstillScratch& scratch) {
  std::vector<Requirement>& requirements = scratch.requirements;
  requirements.clear();
  const double seconds = samples.size() < 2 ? 0 : standstill_means(samples, noise).seconds;
  requirements.push_back(at_least("window", seconds, kFullWindow * s.static_window, "s"));
  if (!all_met(requirements)) return requirements;
  const StandstillMeans means = standstill_means(samples, noise);
  requirements.push_back(at_most("gyroscope standard deviation", means.gyroscope_sigma,
                                 s.static_noise_factor * means.gyroscope_expected, "rad/s"));
  requirements.push_back(at_most("accelerometer standard deviation", means.accelerometer_sigma,
                                 s.static_noise_factor * means.accelerometer_expected, "m/s^2"));
  requirements.push_back(at_most("mean angular rate", means.angular_rate_imu.norm(),
                                 kBiasReach * s.gyroscope_bias_sigma, "rad/s"));
  requirements.push_back(at_most("error of gravity's magnitude",
                                 std::abs(means.specific_force_imu.norm() - s.gravity),
                                 kBiasReach * s.accelerometer_bias_sigma, "m/s^2"));
  if (!all_met(requirements)) return requirements;
  const double noise_pixels = find_displacements(frames, cameras, pixel_sigma, scratch);
  requirements.push_back(
      at_least(kTracks, static_cast<double>(scratch.pixels.size()), s.min_tracks, ""));
  if (!all_met(requirements)) return requirements;
  requirements.push_back(at_most("displacement of the tracks", median(scratch.pixels),
                                 s.static_displacement + noise_pixels, "px"));
  return requirements;
}

}  // namespace chasles
