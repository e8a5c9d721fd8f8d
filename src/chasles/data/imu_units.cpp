#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>

#include <fmt/format.h>

#include <chasles/data/column_names.hpp>
#include <chasles/data/imu_units.hpp>
#include <chasles/error.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {
namespace {

struct UnitFactor {
  std::string_view unit;
  double factor;
};
constexpr double kDegreeUnit = M_PI / 180;
constexpr std::array kRateUnits{UnitFactor{"rad/s", 1},
                                UnitFactor{"rads", 1},
                                UnitFactor{"rad/sec", 1},
                                UnitFactor{"rad s^-1", 1},
                                UnitFactor{"rads^-1", 1},
                                UnitFactor{"rad s-1", 1},
                                UnitFactor{"radians/s", 1},
                                UnitFactor{"rads/s", 1},
                                UnitFactor{"mrad/s", 1e-3},
                                UnitFactor{"dps", kDegreeUnit},
                                UnitFactor{"deg/s", kDegreeUnit},
                                UnitFactor{"degs", kDegreeUnit},
                                UnitFactor{"deg/sec", kDegreeUnit},
                                UnitFactor{"deg s^-1", kDegreeUnit},
                                UnitFactor{"deg s-1", kDegreeUnit},
                                UnitFactor{"degree/s", kDegreeUnit},
                                UnitFactor{"degrees/s", kDegreeUnit},
                                UnitFactor{"degrees/sec", kDegreeUnit},
                                UnitFactor{"deg", kDegreeUnit},
                                UnitFactor{"\u00b0/s", kDegreeUnit},
                                UnitFactor{"\u00ba/s", kDegreeUnit},
                                UnitFactor{"\u00b0/sec", kDegreeUnit},
                                UnitFactor{"mdps", 1e-3 * kDegreeUnit},
                                UnitFactor{"mdeg/s", 1e-3 * kDegreeUnit},
                                UnitFactor{"rpm", 2 * M_PI / 60}};
constexpr std::array kForceUnits{UnitFactor{"m/s^2", 1},
                                 UnitFactor{"m/s2", 1},
                                 UnitFactor{"m s^-2", 1},
                                 UnitFactor{"m/s/s", 1},
                                 UnitFactor{"m s-2", 1},
                                 UnitFactor{"m/s\u00b2", 1},
                                 UnitFactor{"m/s**2", 1},
                                 UnitFactor{"ms2", 1},
                                 UnitFactor{"ms^-2", 1},
                                 UnitFactor{"mps2", 1},
                                 UnitFactor{"mss", 1},
                                 UnitFactor{"mm/s^2", 1e-3},
                                 UnitFactor{"cm/s^2", 1e-2},
                                 UnitFactor{"g", kStandardGravity},
                                 UnitFactor{"gs", kStandardGravity},
                                 UnitFactor{"g's", kStandardGravity},
                                 UnitFactor{"g0", kStandardGravity},
                                 UnitFactor{"gn", kStandardGravity},
                                 UnitFactor{"gravity", kStandardGravity},
                                 UnitFactor{"mg", 1e-3 * kStandardGravity},
                                 UnitFactor{"milli-g", 1e-3 * kStandardGravity},
                                 UnitFactor{"ug", 1e-6 * kStandardGravity},
                                 UnitFactor{"ft/s^2", 0.3048}};
// Raw values of a sensor, whose factor the table does not state; and units of other quantities.
constexpr std::array<std::string_view, 8> kRawUnits{"lsb",  "raw", "count", "digit",
                                                    "volt", "mv",  "adc",   "%"};

using UnitEnding = std::pair<std::string_view, std::string_view>;
constexpr std::array kUnitEndings{
    UnitEnding{"_rad_s", "rad/s"}, UnitEnding{"_rads", "rad/s"},  UnitEnding{"_radps", "rad/s"},
    UnitEnding{"_deg_s", "deg/s"}, UnitEnding{"_degs", "deg/s"},  UnitEnding{"_dps", "dps"},
    UnitEnding{"_m_s2", "m/s^2"},  UnitEnding{"_m_s_2", "m/s^2"}, UnitEnding{"_ms2", "m/s^2"},
    UnitEnding{"_mps2", "m/s^2"},  UnitEnding{"_g", "g"},         UnitEnding{"_mg", "mg"}};

// The unit of a column in brackets, or behind its name (gyro_x_dps).
std::string unit_of_vector(const CsvReader& csv, std::size_t column) {
  std::string unit = bracketed_unit(csv, column);
  return unit.empty() ? without_unit(column_words(csv, column)).second : unit;
}

// The units of a quantity, and those that cannot be its.
struct QuantityUnits {
  std::span<const UnitFactor> units, foreign;
  std::string expected;
};

double factor_of(const CsvReader& csv, std::size_t column, const std::string& unit,
                 const QuantityUnits& quantity) {
  const std::string_view name(unit);
  const auto found = std::ranges::find(quantity.units, name, &UnitFactor::unit);
  if (found != quantity.units.end()) return found->factor;
  const bool raw = std::ranges::any_of(
      kRawUnits, [&](std::string_view text) { return unit.find(text) != std::string::npos; });
  const bool foreign =
      std::ranges::find(quantity.foreign, name, &UnitFactor::unit) != quantity.foreign.end();
  if (!raw && !foreign && !unit.starts_with("deg") && !unit.starts_with("\u00b0")) return 1;
  throw InputError(fmt::format("{}: the unit of {} is {}, expected {}: convert it", csv.where(),
                               csv.columns()[column], unit, quantity.expected));
}

QuantityUnits units_of(ImuQuantity quantity) {
  if (quantity == ImuQuantity::kRate) {
    return {.units = kRateUnits, .foreign = kForceUnits, .expected = "rad/s or deg/s"};
  }
  return {.units = kForceUnits, .foreign = kRateUnits, .expected = "m/s^2 or g"};
}

}  // namespace

std::optional<double> factor_of_unit(std::string_view unit, ImuQuantity quantity) {
  if (unit.empty()) return 1;
  const QuantityUnits known = units_of(quantity);
  const auto found = std::ranges::find(known.units, unit, &UnitFactor::unit);
  return found == known.units.end() ? std::nullopt : std::optional(found->factor);
}

bool has_rate_unit(const CsvReader& csv, std::size_t column) {
  const std::string unit = bracketed_unit(csv, column);
  return std::ranges::find(kRateUnits, std::string_view(unit), &UnitFactor::unit) !=
         kRateUnits.end();
}

std::pair<std::string, std::string> without_unit(const std::string& words) {
  for (const auto& [ending, unit] : kUnitEndings) {
    if (words.size() > ending.size() && words.ends_with(ending)) {
      return {words.substr(0, words.size() - ending.size()), std::string(unit)};
    }
  }
  return {words, ""};
}

VectorColumns with_unit(const CsvReader& csv, const std::array<std::size_t, 3>& axes,
                        ImuQuantity of) {
  const QuantityUnits quantity = units_of(of);
  VectorColumns result{.columns = axes};
  for (const std::size_t column : axes) {
    const std::string unit = unit_of_vector(csv, column);
    const double factor = factor_of(csv, column, unit, quantity);
    if (unit.empty()) continue;  // ax [g],ay,az: the first one speaks for all
    if (!result.unit.empty() && factor != result.factor) {
      throw InputError(fmt::format("{}: {} is in {} and {} in {}, expected one unit", csv.where(),
                                   csv.columns()[axes[0]], result.unit, csv.columns()[column],
                                   unit));
    }
    result.unit = unit;
    result.factor = factor;
  }
  return result;
}

}  // namespace chasles
