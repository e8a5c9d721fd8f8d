#include <algorithm>
#include <cmath>

#include <chasles/check/camera_clock.hpp>

namespace chasles {
namespace {

constexpr double kMostSigma = 0.003;               // [s]
constexpr double kMostOffset = 0.48;               // the search ends at 0.5 [s]
constexpr double kLeastGain = 0.5, kMostGain = 2;  // beyond, another unit
constexpr double kSigmasToStandOut = 10;

}  // namespace

bool CameraClock::stands_out() const {
  return std::abs(offset) > std::max(kLeastOffset, kSigmasToStandOut * sigma);
}

std::optional<CameraClock> camera_clock(const CameraFit& fit) {
  if (!fit.agrees()) return std::nullopt;
  const GyroscopeFit& g = *fit.gyroscope;
  const bool same_motion = !g.mirrored && g.gain > kLeastGain && g.gain < kMostGain;
  const Measured offset = fit.offset();
  if (!same_motion || !(offset.sigma < kMostSigma) || std::abs(offset.value) > kMostOffset) {
    return std::nullopt;
  }
  return CameraClock{.offset = offset.value,
                     .sigma = std::max(offset.sigma, CameraClock::kLeastSigma)};
}

std::optional<CameraClock> camera_clock(const std::vector<FeatureFrame>& tracks,
                                        const std::vector<Camera>& cameras,
                                        const std::vector<ImuSample>& imu) {
  if (cameras.empty() || tracks.empty()) return std::nullopt;
  const auto fit = fit_camera(tracks, cameras, 0, gyroscope_rates(imu));
  return fit ? camera_clock(*fit) : std::nullopt;
}

std::vector<StampedRate> gyroscope_rates(const std::vector<ImuSample>& imu) {
  std::vector<StampedRate> rates;
  rates.reserve(imu.size());
  for (const ImuSample& s : imu) rates.push_back({s.time, s.angular_rate_imu});
  return rates;
}

}  // namespace chasles
