#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/column_names.hpp>
#include <chasles/codec/imu_units.hpp>
#include <chasles/codec/unit_spelling.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {
namespace {

constexpr std::size_t npos = std::string_view::npos;

struct UnitFactor {
  std::string_view unit;
  double factor;
};
constexpr double kDegreeUnit = M_PI / 180;
// As plain_unit() writes them.
constexpr std::array kRateUnits{UnitFactor{"rad/s", 1},
                                UnitFactor{"rads-1", 1},
                                UnitFactor{"rads", 1},
                                UnitFactor{"radps", 1},
                                UnitFactor{"rad", 1},
                                UnitFactor{"1/s", 1},
                                UnitFactor{"s-1", 1},
                                UnitFactor{"mrad/s", 1e-3},
                                UnitFactor{"mrads-1", 1e-3},
                                UnitFactor{"urad/s", 1e-6},
                                UnitFactor{"deg/s", kDegreeUnit},
                                UnitFactor{"degs-1", kDegreeUnit},
                                UnitFactor{"degs", kDegreeUnit},
                                UnitFactor{"degps", kDegreeUnit},
                                UnitFactor{"dps", kDegreeUnit},
                                UnitFactor{"deg", kDegreeUnit},
                                UnitFactor{"mdps", 1e-3 * kDegreeUnit},
                                UnitFactor{"mdegps", 1e-3 * kDegreeUnit},
                                UnitFactor{"mdeg/s", 1e-3 * kDegreeUnit},
                                UnitFactor{"mdegs-1", 1e-3 * kDegreeUnit},
                                UnitFactor{"deg/h", kDegreeUnit / 3600},
                                UnitFactor{"deg/hr", kDegreeUnit / 3600},
                                UnitFactor{"deg/min", kDegreeUnit / 60},
                                UnitFactor{"rev/s", 2 * M_PI},
                                UnitFactor{"revs-1", 2 * M_PI},
                                UnitFactor{"rpm", 2 * M_PI / 60},
                                UnitFactor{"rev/min", 2 * M_PI / 60}};
constexpr std::array kForceUnits{UnitFactor{"m/s2", 1},
                                 UnitFactor{"ms-2", 1},
                                 UnitFactor{"m/s/s", 1},
                                 UnitFactor{"ms2", 1},
                                 UnitFactor{"mps2", 1},
                                 UnitFactor{"mpss", 1},
                                 UnitFactor{"mss", 1},
                                 UnitFactor{"n/kg", 1},
                                 UnitFactor{"mm/s2", 1e-3},
                                 UnitFactor{"mms-2", 1e-3},
                                 UnitFactor{"cm/s2", 1e-2},
                                 UnitFactor{"cms-2", 1e-2},
                                 UnitFactor{"gal", 1e-2},
                                 UnitFactor{"g", kStandardGravity},
                                 UnitFactor{"gs", kStandardGravity},
                                 UnitFactor{"g's", kStandardGravity},
                                 UnitFactor{"g0", kStandardGravity},
                                 UnitFactor{"gn", kStandardGravity},
                                 UnitFactor{"gee", kStandardGravity},
                                 UnitFactor{"gees", kStandardGravity},
                                 UnitFactor{"gforce", kStandardGravity},
                                 UnitFactor{"gravity", kStandardGravity},
                                 UnitFactor{"mg", 1e-3 * kStandardGravity},
                                 UnitFactor{"mgs", 1e-3 * kStandardGravity},
                                 UnitFactor{"ug", 1e-6 * kStandardGravity},
                                 UnitFactor{"ft/s2", 0.3048},
                                 UnitFactor{"fts-2", 0.3048}};
// Brackets that state no unit: none, or whose values these are.
constexpr std::array<std::string_view, 17> kNoUnits{
    "",          "-",     "1",           "si",     "si units", "imu",        "imu0",
    "imu frame", "body",  "sensor",      "device", "filtered", "calibrated", "uncalibrated",
    "corrected", "total", "with gravity"};

const UnitFactor* known_unit(std::span<const UnitFactor> units, std::string_view unit) {
  const std::string plain = plain_unit(unit);
  const auto found = std::ranges::find(units, std::string_view(plain), &UnitFactor::unit);
  return found == units.end() ? nullptr : &*found;
}

bool ends_in_axis(const std::string& name) {
  return (!name.empty() && name.back() >= 'x' && name.back() <= 'z') ||
         (name.size() > 2 && name[0] >= 'x' && name[0] <= 'z' && name[1] == '_');
}

// The unit of words behind a name: rad_s, m_s_2, mdps; empty for others. Angles have no rates.
std::string unit_of_words(const std::string& words) {
  constexpr std::array<std::string_view, 4> kOthers{"deg", "rad", "gravity", "s_1"};
  if (std::ranges::find(kOthers, std::string_view(words)) != kOthers.end()) return {};
  std::string divided = words;
  if (const std::size_t at = divided.find('_'); at != npos) divided[at] = '/';
  for (const std::string& unit : {divided, words}) {
    const std::string plain = plain_unit(unit);
    if (known_unit(kRateUnits, plain) == nullptr && known_unit(kForceUnits, plain) == nullptr) {
      continue;
    }
    return plain == "degs" ? "deg/s" : plain;
  }
  return {};
}

// The unit of a column in brackets, or behind its name (gyro_x_dps).
std::string unit_of_vector(const CsvReader& csv, std::size_t column) {
  std::string unit = bracketed_unit(csv, column);
  return unit.empty() ? without_unit(column_words(csv, column)).second : unit;
}

// The units of a quantity, and the usual ones for messages.
struct QuantityUnits {
  std::span<const UnitFactor> units;
  std::string expected, known;
};

double factor_of(const CsvReader& csv, std::size_t column, const std::string& unit,
                 const QuantityUnits& quantity) {
  if (const UnitFactor* found = known_unit(quantity.units, unit)) return found->factor;
  if (std::ranges::find(kNoUnits, std::string_view(unit)) != kNoUnits.end()) return 1;
  if (unit.ends_with("frame")) return 1;
  throw InputError(fmt::format(
      "{}: the unit of {} is {}, expected {} (known are {}): convert it, or remove the brackets if "
      "what they hold is no unit",
      csv.where(), csv.columns()[column], unit, quantity.expected, quantity.known));
}

QuantityUnits units_of(ImuQuantity quantity) {
  if (quantity == ImuQuantity::kRate) {
    return {.units = kRateUnits,
            .expected = "rad/s or deg/s",
            .known = "rad/s, mrad/s, urad/s, deg/s, mdeg/s, dps, mdps, deg/h, rev/s and rpm"};
  }
  return {.units = kForceUnits,
          .expected = "m/s^2 or g",
          .known = "m/s^2, cm/s^2, mm/s^2, ft/s^2, Gal, g, mg and ug"};
}

}  // namespace

std::optional<double> factor_of_unit(std::string_view unit, ImuQuantity quantity) {
  if (unit.empty()) return 1;
  const UnitFactor* found = known_unit(units_of(quantity).units, unit);
  return found == nullptr ? std::nullopt : std::optional(found->factor);
}

bool has_rate_unit(const CsvReader& csv, std::size_t column) {
  return known_unit(kRateUnits, bracketed_unit(csv, column)) != nullptr;
}

std::pair<std::string, std::string> without_unit(const std::string& words) {
  for (const std::string_view force : {"g_f", "gf_", "g_force_", "gforce_"}) {  // in g by its name
    if (words.size() == force.size() + 1 && words.starts_with(force) && ends_in_axis(words)) {
      return {fmt::format("acc_{}", words.back()), "g"};
    }
  }
  for (std::size_t at = 0; (at = words.find('_', at)) != npos; ++at) {
    std::string name = words.substr(0, at), unit = unit_of_words(words.substr(at + 1));
    if (!unit.empty() && ends_in_axis(name)) return {name, unit};
  }
  const std::size_t axis = words.rfind('_');  // gyro_dps_x
  if (axis == npos || axis + 2 != words.size() || !ends_in_axis(words)) return {words, ""};
  for (std::size_t at = 2; (at = words.find('_', at + 1)) < axis;) {
    std::string unit = unit_of_words(words.substr(at + 1, axis - at - 1));
    if (!unit.empty()) return {words.substr(0, at) + words.substr(axis), unit};
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
