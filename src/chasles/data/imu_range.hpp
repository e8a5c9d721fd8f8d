#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <chasles/data/recording.hpp>
#include <chasles/data/yaml_map.hpp>

namespace chasles {

/// Keys `accelerometer_range` [m/s^2] and `gyroscope_range` [rad/s] of a file of calibration, each
/// where it is there. Throws InputError unless they are positive.
ImuRange read_imu_range(const YamlMap& map);

/// The lines that read_imu_range() reads; empty where nothing is stated.
std::string imu_range_text(const ImuRange& range);

/// What the samples themselves show: a sensor whose largest value, either way and of all three
/// axes, is that of three or more successive samples of an axis to the last bit is clipped there
/// (less 0.1 %: the two ends of a range differ by a count). Noise does not do that by chance; so
/// nothing is claimed below two g and 125 deg/s, which no sensor clips at, nor of a sensor whose
/// samples repeat anyhow (more than one of twenty is the one before). Infinite where nothing shows.
ImuRange shown_range(const std::vector<ImuSample>& imu);

/// As the recording states it; of a sensor of which it does not, as its samples show it.
ImuRange range_of(const Recording& recording);

/// Samples with a component at the edge of the range or beyond.
std::size_t count_saturated(const std::vector<ImuSample>& imu, const ImuRange& range);

}  // namespace chasles
