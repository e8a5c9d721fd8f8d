#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/recording/imu_sense.hpp>

namespace chasles {
namespace {

constexpr std::size_t kFewSamples = 100;
constexpr double kLeastForce = 0.3 * kStandardGravity;  // of the median, with gravity [m/s^2]

// Lengths in order; those that are not finite are left out.
template <typename Of>
std::vector<double> lengths(std::size_t count, const Of& of) {
  std::vector<double> result;
  for (std::size_t i = 0; i < count; ++i) {
    const double length = of(i).norm();
    if (std::isfinite(length)) result.push_back(length);
  }
  std::ranges::sort(result);
  return result;
}

double quantile(const std::vector<double>& sorted, double part) {
  return sorted[static_cast<std::size_t>(part * static_cast<double>(sorted.size() - 1))];
}

// The length of vectors that all have that of gravity, in g or m/s^2; none for others. No gyroscope
// measures rates of one length about changing axes.
std::optional<double> length_of_gravity(const std::vector<double>& sorted,
                                        std::size_t fewest = kFewSamples) {
  if (sorted.size() < fewest) return std::nullopt;
  const double middle = quantile(sorted, 0.5);
  const bool same =
      quantile(sorted, 0.01) > 0.99 * middle && quantile(sorted, 0.99) < 1.01 * middle;
  const bool gravity = std::abs(middle - 1) < 0.02 || std::abs(middle - kStandardGravity) < 0.1;
  return same && gravity ? std::optional(middle) : std::nullopt;
}

std::string names_of(const CsvReader& csv, const VectorColumns& v) {
  return fmt::format("{}, {}, {}", csv.columns()[v.columns[0]], csv.columns()[v.columns[1]],
                     csv.columns()[v.columns[2]]);
}

const char* const kExpected =
    "expected the accelerometer's samples, with gravity, in m/s^2 and the gyroscope's in rad/s";
const char* const kWriteRaw =
    "expected the accelerometer's own samples, with gravity (9.81 m/s^2 upwards at a standstill), "
    "as ax,ay,az in m/s^2 and the gyroscope's as wx,wy,wz in rad/s: record those of the sensor "
    "(raw, total acceleration), not those of the phone's motion fusion";

// Tables of no measurement, and of the rates in the columns of the forces.
void check_forces(const CsvReader& csv, const std::string& file, const ImuColumns& columns,
                  double force, const std::vector<ImuSample>& imu) {
  if (force >= kLeastForce) return;
  const std::vector<double> rates = lengths(
      imu.size(), [&](std::size_t i) -> const Eigen::Vector3d& { return imu[i].angular_rate_imu; });
  const double rate = rates.empty() ? 0 : quantile(rates, 0.5);
  const std::string forces = names_of(csv, columns.force), turns = names_of(csv, columns.rate);
  if (std::abs(rate - kStandardGravity) < 0.2 * kStandardGravity) {
    throw InputError(fmt::format(
        "{}: accelerometer and gyroscope are exchanged: the median length of {} is {:.2f}, which "
        "is gravity, and that of {} is {:.2f}; expected {} in rad/s, and {} in m/s^2",
        file, turns, rate, forces, force, turns, forces));
  }
  if (quantile(lengths(imu.size(),
                       [&](std::size_t i) -> const Eigen::Vector3d& {
                         return imu[i].specific_force_imu;
                       }),
               0.99) > 0) {
    return;
  }
  const bool all = rates.empty() || quantile(rates, 0.99) == 0;
  throw InputError(
      all ? fmt::format("{}: all six columns ({}, {}) are 0 in all {} samples: the sensor was not "
                        "read, or the driver writes the attitude alone; {}",
                        file, turns, forces, imu.size(), kExpected)
          : fmt::format("{}: {} are 0 in all {} samples: the accelerometer was not read; {}", file,
                        forces, imu.size(), kExpected));
}

void check_gravity_columns(const CsvReader& csv, const std::string& file, const ImuColumns& columns,
                           const std::optional<double>& length, bool assessed) {
  if (length || !assessed) return;
  throw InputError(fmt::format("{}: both {} and {} may be the angular rates, expected one of them",
                               file, names_of(csv, columns.rate), names_of(csv, *columns.gravity)));
}

void check_rates(const CsvReader& csv, const std::string& file, const ImuColumns& columns,
                 const std::vector<ImuSample>& imu) {
  const auto length =
      length_of_gravity(lengths(imu.size(), [&](std::size_t i) -> const Eigen::Vector3d& {
        return imu[i].angular_rate_imu;
      }));
  if (!length) return;
  throw InputError(fmt::format(
      "{}: {} have the length {:.3f} in all samples: they are the direction of gravity, no angular "
      "rates; {}",
      file, names_of(csv, columns.rate), *length, kWriteRaw));
}

}  // namespace

void take_rates_of_g(const CsvReader& csv, ImuColumns& columns,
                     std::vector<Eigen::Vector3d>& gravity, std::vector<ImuSample>& imu,
                     std::vector<std::string>& remarks) {
  if (!columns.gravity || !columns.rate_is_derived) return;
  const auto length = length_of_gravity(
      lengths(gravity.size(), [&](std::size_t i) -> const Eigen::Vector3d& { return gravity[i]; }),
      1);
  if (length) return;
  const VectorColumns g = with_unit(csv, columns.gravity->columns, ImuQuantity::kRate);
  remarks.push_back(fmt::format("the angular rates are {}, and {} are not read", names_of(csv, g),
                                names_of(csv, columns.rate)));
  for (std::size_t i = 0; i < imu.size(); ++i) imu[i].angular_rate_imu = g.factor * gravity[i];
  columns.rate = g;
  columns.gravity.reset();
  gravity.clear();
}

void check_sense(const CsvReader& csv, const std::string& file, const ImuColumns& columns,
                 const std::vector<ImuSample>& imu, const std::vector<Eigen::Vector3d>& gravity,
                 std::vector<std::string>& remarks) {
  const bool assessed = imu.size() >= kFewSamples;
  const auto length = length_of_gravity(
      lengths(gravity.size(), [&](std::size_t i) -> const Eigen::Vector3d& { return gravity[i]; }));
  if (columns.gravity) check_gravity_columns(csv, file, columns, length, assessed);
  check_rates(csv, file, columns, imu);
  const std::vector<double> forces =
      lengths(imu.size(),
              [&](std::size_t i) -> const Eigen::Vector3d& { return imu[i].specific_force_imu; });
  if (forces.size() < kFewSamples) return;
  const double median = quantile(forces, 0.5);
  check_forces(csv, file, columns, median, imu);
  const std::string more =
      length ? fmt::format(", and {}, of the length {:.3f}, are the direction of gravity",
                           names_of(csv, *columns.gravity), *length)
             : "";
  if (quantile(forces, 0.25) > 0.8 && quantile(forces, 0.75) < 1.3) {
    remarks.push_back(fmt::format(
        "the median of the specific force is {:.2f} m/s^2, and gravity is 9.81: is it in g? Write "
        "the unit behind the names of the columns, as in ax [g]",
        median));
  } else if (median < kLeastForce) {
    throw InputError(fmt::format(
        "{}: gravity is removed from {}: the median of their length is {:.2f} m/s^2{}; {}", file,
        names_of(csv, columns.force), median, more, kWriteRaw));
  }
  if (length) {
    remarks.push_back(fmt::format("{} are the direction of gravity: the angular rates are {}",
                                  names_of(csv, *columns.gravity), names_of(csv, columns.rate)));
  }
}

}  // namespace chasles
