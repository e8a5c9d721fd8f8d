#include <cmath>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/numeric/random.hpp>
#include <chasles/sim/inertial_imu.hpp>

namespace chasles {
namespace {

constexpr double kMostSamples = 1e7;

const Eigen::Vector3d kGravity(0, 0, -kStandardGravity);

ImuSample instant(const Motion& motion, Time time) {
  return {.time = time,
          .specific_force_imu = motion.world_T_imu.R.transpose() * (motion.a_world - kGravity),
          .angular_rate_imu = motion.omega_imu};
}

ImuSample mean(const Motion& from, const Motion& to, Time time, double tau) {
  const Eigen::Matrix3d& R = from.world_T_imu.R;
  const Eigen::Vector3d turn = so3::log(R.transpose() * to.world_T_imu.R);
  const Eigen::Vector3d dv = R.transpose() * (to.v_world - from.v_world - tau * kGravity);
  return {.time = time,
          .specific_force_imu = so3::left_jacobian_inverse(turn) * dv / tau,
          .angular_rate_imu = turn / tau};
}

Eigen::Vector3d draw(const Random& random, Stream stream, std::uint64_t index, double sigma) {
  return sigma * Eigen::Vector3d(random.normal(stream, index, 0), random.normal(stream, index, 1),
                                 random.normal(stream, index, 2));
}

}  // namespace

std::vector<ImuSample> ideal_imu(const Spline& motion, double rate, ImuConvention convention) {
  // The half nanosecond includes the last sample if the duration is a whole number of samples.
  const double count = std::floor((motion.duration + 0.5e-9) * rate) + 1;
  if (count > kMostSamples) {
    throw UsageError(fmt::format(
        "simulation setting imu_rate = {} Hz: {:.3g} samples in {:.0f} s; expected at most {:.0g}",
        rate, count, motion.duration, kMostSamples));
  }
  std::vector<ImuSample> samples;
  Motion last;
  for (double k = 0; k < count; ++k) {
    const Time since = from_seconds(k / rate);
    const Motion now = motion_at(motion, to_seconds(since));
    const Time time = motion.start + since;
    ImuSample sample = instant(now, time);
    if (!is_rate_of_instant(convention) && !samples.empty()) {
      const ImuSample means = mean(last, now, time, to_seconds(time - samples.back().time));
      sample.angular_rate_imu = means.angular_rate_imu;
      if (!is_force_of_instant(convention)) sample.specific_force_imu = means.specific_force_imu;
    }
    samples.push_back(sample);
    last = now;
  }
  return samples;
}

SimulatedImu simulate_imu(const InertialSettings& settings, const Spline& motion,
                          std::uint64_t run) {
  SimulatedImu imu{ideal_imu(motion, settings.imu_rate, settings.imu_convention), {}};
  const Random random = random_of_run(settings.seed, run);
  const double root = std::sqrt(settings.imu_rate);
  Eigen::Vector3d bias_f =
      draw(random, Stream::kAccelerometerBias, 0, settings.accelerometer_bias_sigma);
  Eigen::Vector3d bias_w = draw(random, Stream::kGyroscopeBias, 0, settings.gyroscope_bias_sigma);
  for (std::uint64_t k = 0; k < imu.samples.size(); ++k) {
    ImuSample& sample = imu.samples[k];
    const Motion now = motion_at(motion, to_seconds(sample.time - motion.start));
    imu.truth.push_back({sample.time, now.v_world, bias_f, bias_w});
    sample.specific_force_imu += bias_f + draw(random, Stream::kAccelerometerNoise, k,
                                               settings.accelerometer_noise_density * root);
    sample.angular_rate_imu +=
        bias_w + draw(random, Stream::kGyroscopeNoise, k, settings.gyroscope_noise_density * root);
    bias_f +=
        draw(random, Stream::kAccelerometerWalk, k, settings.accelerometer_random_walk / root);
    bias_w += draw(random, Stream::kGyroscopeWalk, k, settings.gyroscope_random_walk / root);
  }
  return imu;
}

ImuNoise imu_noise(const InertialSettings& settings) {
  return {.accelerometer_noise_density = settings.accelerometer_noise_density,
          .accelerometer_random_walk = settings.accelerometer_random_walk,
          .gyroscope_noise_density = settings.gyroscope_noise_density,
          .gyroscope_random_walk = settings.gyroscope_random_walk};
}

}  // namespace chasles
