#pragma once

#include <array>
#include <cstdint>

namespace chasles {

/// The purpose of a random number. Each purpose has its own stream: switching one noise source on
/// or off does not change the numbers of the others.
enum class Stream : std::uint32_t {
  kLinearNoise = 1,
  kAngularNoise = 2,
  kBirth = 3,
  kLife = 4,
  kPixelNoise = 5,
  kDisparityError = 6,
  kOutlier = 7,
  kMoving = 8,
  kDropped = 9,
  kAccelerometerNoise = 10,
  kGyroscopeNoise = 11,
  kAccelerometerBias = 12,
  kGyroscopeBias = 13,
  kAccelerometerWalk = 14,
  kGyroscopeWalk = 15,
  kLandmark = 16,
  kStart = 17,
  kTexture = 18,
  kImageNoise = 19,
  kExposure = 20,
  kTrackKept = 21,
  kTrackDrift = 22,
  kMatchError = 23,
};

/// 128 random bits as a pure function of a counter and a key: Philox-4x32 with ten rounds (Salmon,
/// Moraes, Dror, Shaw: "Parallel random numbers: as easy as 1, 2, 3", SC 2011).
std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> counter,
                                    std::array<std::uint32_t, 2> key);

/// Random numbers without a state. A number depends on the seed, stream, index and component, not
/// on earlier draws. The order of evaluation and the number of threads do not matter. The
/// distributions are implemented here, because those of <random> differ between standard libraries.
struct Random {
  std::uint64_t seed = 0;

  /// Uniform in the open interval (0, 1), in steps of 2^-52.
  double uniform(Stream stream, std::uint64_t index, std::uint32_t component = 0) const;

  /// Normal, mean 0, variance 1 (Box-Muller).
  double normal(Stream stream, std::uint64_t index, std::uint32_t component = 0) const;
};

/// The numbers of one run of a Monte Carlo study, independent of those of the seed itself and of
/// every other run. The new seed is the Philox output for the run's number under `seed`.
Random random_of_run(std::uint64_t seed, std::uint64_t run);

}  // namespace chasles
