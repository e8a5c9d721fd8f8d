#pragma once

#include <string>
#include <vector>

#include <chasles/imu/imu_sample.hpp>
#include <chasles/recording/imu_columns.hpp>

namespace chasles {

/// If gx, gy, gz beside derived rates (ImuColumns::rate_is_derived) are no gravity, they become the
/// rates of the samples, with a remark. `gravity`: their values, left empty then.
void take_rates_of_g(const CsvReader& csv, ImuColumns& columns,
                     std::vector<Eigen::Vector3d>& gravity, std::vector<ImuSample>& imu,
                     std::vector<std::string>& remarks);

/// Checks the samples of a table against what its names say. `gravity`: the columns gx, gy, gz
/// beside other angular rates, empty without them. Tables of fewer than 100 samples are not
/// assessed.
///
/// Throws InputError if all forces are 0, if the rates have the length of gravity and the forces
/// have not (exchanged columns), if the forces have no gravity in them, as a phone's user or linear
/// acceleration, and if columns named as angular rates are the direction of gravity. It is not
/// added again: systems differ in the signs of both. Adds a remark on forces that seem to be in g.
void check_sense(const CsvReader& csv, const std::string& file, const ImuColumns& columns,
                 const std::vector<ImuSample>& imu, const std::vector<Eigen::Vector3d>& gravity,
                 std::vector<std::string>& remarks);

}  // namespace chasles
