#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <chasles/codec/yaml_map.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {

/// The optional keys `accelerometer_range` [m/s^2] and `gyroscope_range` [rad/s] of a calibration
/// file. Throws InputError unless they are positive.
ImuRange read_imu_range(const YamlMap& map);

/// The lines that read_imu_range() reads, each after `indent`; empty if the range is infinite.
std::string imu_range_text(const ImuRange& range, const std::string& indent = "");

/// Estimates the range of each sensor from its samples. The range is the largest magnitude over the
/// three axes, if three or more successive samples of an axis have it to the last bit; the result
/// is 0.1 % smaller, because the two ends of a range differ by a count. Noise does not produce such
/// runs. Values below two g and 125 deg/s are not taken as a range, because no sensor clips there.
/// Sensors that often repeat a sample (more than one in twenty) are not evaluated. Infinite if no
/// clipping is found.
ImuRange shown_range(const std::vector<ImuSample>& imu);

/// The number of samples with a component at the limit of the range or beyond.
std::size_t count_saturated(const std::vector<ImuSample>& imu, const ImuRange& range);

}  // namespace chasles
