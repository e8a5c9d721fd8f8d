#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include <chasles/imu/imu_sample.hpp>

namespace chasles {

/// White-noise densities that a motion adds to those that an IMU has at a standstill. The
/// variances add: N^2 = N_stated^2 + added^2.
struct AddedNoise {
  double accelerometer = 0;  ///< [m/s^2/sqrt(Hz)]
  double gyroscope = 0;      ///< [rad/s/sqrt(Hz)]
};

/// Estimates the noise of a vibrating IMU from its samples. Samples of a vibration faster than
/// half of their rate are aliased: a part of it appears at low frequencies, where nothing separates
/// it from motion, and is integrated as white noise. The rest of the aliased vibration is in the
/// middle of the band, where the differences
///   D_k = (x_k + x_{k-1} - x_{k-2} - x_{k-3}) / 2
/// measure it: their gain is 2 |cos(w/2) sin w|, with a maximum of 1.54 at 0.2 of the rate. A
/// second term is proportional to the signal's variance. It stands for what grows with the motion
/// itself: scale, misalignment, integration. With means over the last second and the three axes,
///   added^2 = c_v^2 <D^2> dt + c_m^2 max(0, var(x) - <D^2>),
/// c_v = 0.5, c_m = 0.005 s^(1/2) for the accelerometer; 0.15, 0.001 s^(1/2) for the gyroscope.
/// The constants were fitted on recordings with 200 Hz (docs/noise.md).
///
/// White noise of density N has <D^2> dt = N^2 at every rate. At a standstill the added noise is
/// therefore 0.5 N of the accelerometer and 0.15 N of the gyroscope: their densities become 12 %
/// and 1 % larger.
///
/// The result depends only on the samples of the last 1.1 s, whatever came before. It takes a
/// constant time for a sample, and no memory from the heap.
class VibrationNoise {
 public:
  /// Values that are no measurement of the signal, such as saturated ones.
  struct Unusable {
    bool force = false, rate = false;
  };

  /// The added noise at the time of a sample, which is finite and later than the one before (as
  /// SampleScreen releases them). Zero before four usable samples of the sensor without a gap
  /// between them. Each sensor by itself.
  AddedNoise add(const ImuSample& sample, Unusable unusable = {false, false});

 private:
  struct Constants {
    double vibration = 0;  ///< c_v
    double motion = 0;     ///< c_m [s^(1/2)]
  };
  /// The sums over the samples of 0.1 s, which begin at multiples of it.
  struct Block {
    std::int64_t number = -1;
    int samples = 0, differences = 0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double squares = 0;           ///< |x|^2
    double difference2 = 0;       ///< |D|^2
    double difference2_time = 0;  ///< |D|^2 dt
  };
  /// The signal of one sensor.
  class Signal {
   public:
    explicit Signal(Constants constants) : constants_(constants) {}
    double add(Time time, const Eigen::Vector3d& value, bool usable);

   private:
    static constexpr std::size_t kBlocks = 11;  // the last second, and the present part of 0.1 s
    struct Recent {
      Time time{};
      Eigen::Vector3d value = Eigen::Vector3d::Zero();
    };

    static std::size_t place(std::int64_t number);
    Block& block_at(Time time);
    void note(const Recent& now, Block& block);
    double density(std::int64_t number) const;

    Constants constants_;
    std::array<Recent, 4> recent_;  ///< without a gap; the latest first
    int count_ = 0;                 ///< of them
    std::array<Block, kBlocks> blocks_;
  };

  Signal force_{{.vibration = 0.5, .motion = 0.005}};
  Signal rate_{{.vibration = 0.15, .motion = 0.001}};
};

}  // namespace chasles
