#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <chasles/slam/rest_conditions.hpp>
#include <chasles/slam/rest_start.hpp>

namespace chasles {
namespace {

constexpr double kMedianOfRayleigh = 1.1774;  // of the length of a normal vector in the plane
constexpr double kBiasReach = 4;              // deviations of a bias's prior, in length
constexpr double kFullWindow = 0.95;

// How far each track moved between the halves of the window, and what noise alone would do.
struct Displacements {
  std::vector<double> pixels;
  double noise = 0;  ///< median that noise makes [px]
};

struct Halves {
  Eigen::Vector2d sum[2] = {Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  int count[2] = {0, 0};
};

Displacements displacements(std::span<const FeatureFrame> frames, std::size_t cameras,
                            double pixel_sigma) {
  std::map<std::pair<LandmarkId, int>, Halves> tracks;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::size_t half = 2 * i < frames.size() ? 0 : 1;
    for (const PixelObservation& o : frames[i].pixels) {
      if (!o.pixel.allFinite() || o.camera < 0 || std::cmp_greater_equal(o.camera, cameras)) {
        continue;
      }
      Halves& track = tracks[{o.landmark, o.camera}];
      track.sum[half] += o.pixel;
      ++track.count[half];
    }
  }
  Displacements result;
  double variance = 0;
  for (const auto& [key, track] : tracks) {
    if (2 * static_cast<std::size_t>(track.count[0] + track.count[1]) < frames.size()) continue;
    if (track.count[0] == 0 || track.count[1] == 0) continue;
    result.pixels.push_back((track.sum[1] / track.count[1] - track.sum[0] / track.count[0]).norm());
    variance += 1.0 / track.count[0] + 1.0 / track.count[1];
  }
  if (result.pixels.empty()) return result;
  variance /= static_cast<double>(result.pixels.size());
  result.noise = kMedianOfRayleigh * pixel_sigma * std::sqrt(variance);
  return result;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace

std::vector<Requirement> rest_conditions(std::span<const ImuSample> samples,
                                         std::span<const FeatureFrame> frames, std::size_t cameras,
                                         const ImuNoise& noise, double pixel_sigma,
                                         const InitialiserSettings& s) {
  std::vector<Requirement> requirements;
  const double seconds = samples.size() < 2 ? 0 : rest_means(samples, noise).seconds;
  requirements.push_back(at_least("window", seconds, kFullWindow * s.rest_window, "s"));
  if (!all_met(requirements)) return requirements;
  const RestMeans means = rest_means(samples, noise);
  requirements.push_back(at_most("gyroscope deviation", means.gyroscope_deviation,
                                 s.rest_noise_factor * means.gyroscope_expected, "rad/s"));
  requirements.push_back(at_most("accelerometer deviation", means.accelerometer_deviation,
                                 s.rest_noise_factor * means.accelerometer_expected, "m/s^2"));
  requirements.push_back(at_most("mean angular rate", means.angular_rate_imu.norm(),
                                 kBiasReach * s.gyroscope_bias_sigma, "rad/s"));
  requirements.push_back(at_most("deviation of gravity's magnitude",
                                 std::abs(means.specific_force_imu.norm() - s.gravity),
                                 kBiasReach * s.accelerometer_bias_sigma, "m/s^2"));
  if (!all_met(requirements)) return requirements;
  const Displacements moved = displacements(frames, cameras, pixel_sigma);
  requirements.push_back(
      at_least(kTracks, static_cast<double>(moved.pixels.size()), s.min_tracks, ""));
  if (!all_met(requirements)) return requirements;
  requirements.push_back(at_most("displacement of the tracks", median(moved.pixels),
                                 s.rest_displacement + moved.noise, "px"));
  return requirements;
}

}  // namespace chasles
