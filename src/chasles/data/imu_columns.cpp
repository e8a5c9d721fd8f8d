#include <algorithm>
#include <cctype>
#include <cmath>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/data/imu_columns.hpp>
#include <chasles/data/text_file.hpp>
#include <chasles/error.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {
namespace {

using Spellings = std::span<const std::string_view>;

// Before the letter of the axis: the names of this program, EuRoC, Kalibr and ROS.
constexpr std::array<std::string_view, 15> kRateNames{"w",
                                                      "w_",
                                                      "w_rs_s_",
                                                      "omega",
                                                      "omega_",
                                                      "g",
                                                      "g_",
                                                      "gyro",
                                                      "gyro_",
                                                      "gyr_",
                                                      "gyroscope_",
                                                      "angular_velocity_",
                                                      "angular_velocity.",
                                                      "field.angular_velocity.",
                                                      "angular_rate_"};
constexpr std::array<std::string_view, 16> kForceNames{"a",
                                                       "a_",
                                                       "a_rs_s_",
                                                       "alpha",
                                                       "alpha_",
                                                       "acc",
                                                       "acc_",
                                                       "accel_",
                                                       "acceleration_",
                                                       "accelerometer_",
                                                       "linear_acceleration_",
                                                       "linear_acceleration.",
                                                       "field.linear_acceleration.",
                                                       "specific_force_",
                                                       "f",
                                                       "f_"};
// Of others, with any words before them: /imu/angular_velocity/x, Gyroscope x (rad/s).
constexpr std::array<std::string_view, 17> kRateWords{"omega",
                                                      "gyro",
                                                      "gyr",
                                                      "gyros",
                                                      "gyroscope",
                                                      "angular_velocity",
                                                      "angularvelocity",
                                                      "angular_rate",
                                                      "angularrate",
                                                      "ang_vel",
                                                      "angvel",
                                                      "rotation_rate",
                                                      "rotationrate",
                                                      "rot_rate",
                                                      "gyrorotationrate",
                                                      "motionrotationrate",
                                                      "angular_vel"};
constexpr std::array<std::string_view, 16> kForceWords{"acc",
                                                       "accel",
                                                       "acceleration",
                                                       "accelerometer",
                                                       "linear_acceleration",
                                                       "linearacceleration",
                                                       "lin_acc",
                                                       "linacc",
                                                       "linear_acc",
                                                       "lin_accel",
                                                       "specific_force",
                                                       "specificforce",
                                                       "accelerometeracceleration",
                                                       "accelerometer_acceleration",
                                                       "totalacceleration",
                                                       "total_acceleration"};
constexpr std::array<std::string_view, 1> kShortRates{"w"};
constexpr std::array<std::string_view, 2> kShortForces{"a", "f"};
// Angular rates, unless others are there: gravity is written so as well.
constexpr std::array<std::string_view, 2> kGNames{"g", "g_"};
constexpr std::array<std::string_view, 1> kShortG{"g"};
// Words of quantities that are no specific forces, whatever follows.
constexpr std::array<std::string_view, 3> kNotForces{"user", "gravity", "world"};

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

// A name in small letters, without brackets, with _ between its words.
std::string words_of(const CsvReader& csv, std::size_t column) {
  std::string words;
  for (const char c : lower_case(csv.columns()[column])) {
    const bool letter = std::isalnum(static_cast<unsigned char>(c)) != 0 || (c & 0x80) != 0;
    if (letter) {
      words += c;
    } else if (!words.empty() && words.back() != '_') {
      words += '_';
    }
  }
  while (words.ends_with('_')) words.pop_back();
  return words;
}

// The last word of a name and what is before it.
std::pair<std::string, std::string> last_word(const std::string& words) {
  const std::size_t at = words.rfind('_');
  if (at == std::string::npos) return {"", words};
  return {words.substr(0, at), words.substr(at + 1)};
}

// The text of the first pair of brackets behind a name, in small letters; empty without one.
std::string bracketed_unit(const CsvReader& csv, std::size_t column) {
  const std::string& heading = csv.headings()[column];
  for (const auto& [open, close] : {std::pair('[', ']'), std::pair('(', ')')}) {
    const std::size_t begin = heading.find(open);
    if (begin == std::string::npos) continue;
    const std::size_t end = heading.find(close, begin);
    if (end != std::string::npos) {
      return lower_case(trimmed(std::string_view(heading).substr(begin + 1, end - begin - 1)));
    }
  }
  return {};
}

[[noreturn]] void unknown_names(const CsvReader& csv, const std::string& missing) {
  throw InputError(fmt::format(
      "{}: has the columns {}, and none is {}: expected names as time_ns,wx,wy,wz,ax,ay,az or "
      "EuRoC's (angular rates in rad/s, specific forces in m/s^2)",
      csv.where(), fmt::join(csv.headings(), ","), missing));
}

[[noreturn]] void two_columns(const CsvReader& csv, std::size_t a, std::size_t b,
                              const std::string& what) {
  throw InputError(fmt::format("{}: both {} and {} may be {}, expected one of them", csv.where(),
                               csv.columns()[a], csv.columns()[b], what));
}

// The only column for which `is` holds; none without one.
template <typename Is>
std::optional<std::size_t> only_column(const CsvReader& csv, const std::string& what,
                                       const Is& is) {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < csv.columns().size(); ++i) {
    if (!is(i)) continue;
    if (found) two_columns(csv, *found, i, what);
    found = i;
  }
  return found;
}

// ---- vectors

// Whether a name is one of these with the axis behind it.
bool spelled(const std::string& name, Spellings names, char axis) {
  return std::ranges::any_of(names, [&](std::string_view known) {
    return name.size() == known.size() + 1 && name.starts_with(known) && name.ends_with(axis);
  });
}

// A name without a unit behind it, and that unit; empty without one.
std::pair<std::string, std::string> without_unit(const std::string& words) {
  for (const auto& [ending, unit] : kUnitEndings) {
    if (words.size() > ending.size() && words.ends_with(ending)) {
      return {words.substr(0, words.size() - ending.size()), std::string(unit)};
    }
  }
  return {words, ""};
}

// A name without its axis and unit: gyro of gyro_x_dps, gyrox and x_gyro.
std::optional<std::string> name_along(const std::string& words, char axis) {
  std::string name = without_unit(words).first;
  if (name.size() > 2 && name[0] == axis && name[1] == '_') return name.substr(2);
  if (name.size() < 2 || name.back() != axis) return std::nullopt;
  name.pop_back();
  if (name.ends_with('_')) name.pop_back();
  return name;
}

// Whether a name of several words ends with this one.
bool ends_in_word(const std::string& words, std::string_view word) {
  return words.size() > word.size() && words.ends_with(word) &&
         words[words.size() - word.size() - 1] == '_';
}

bool ends_with_word(const std::string& words, Spellings known, Spellings shorts) {
  const bool foreign = std::ranges::any_of(
      kNotForces, [&](std::string_view word) { return words.find(word) != std::string::npos; });
  if (std::ranges::find(shorts, std::string_view(words)) != shorts.end()) return true;
  return !foreign && std::ranges::any_of(known, [&](std::string_view word) {
    return words == word || ends_in_word(words, word);
  });
}

using Axes = std::array<std::size_t, 3>;

// The three columns for which `is(column, axis)` holds; none if one of them is missing.
template <typename Is>
std::optional<Axes> axes_where(const CsvReader& csv, const std::string& what, const Is& is) {
  Axes axes{};
  for (std::size_t k = 0; k < 3; ++k) {
    const char axis = "xyz"[k];
    const auto found = only_column(csv, fmt::format("the {} about or along {}", what, axis),
                                   [&](std::size_t i) { return is(i, axis); });
    if (!found) return std::nullopt;
    axes[k] = *found;
  }
  return axes;
}

std::optional<Axes> axes_spelled(const CsvReader& csv, Spellings names, const std::string& what) {
  return axes_where(csv, what, [&](std::size_t i, char axis) {
    return spelled(lower_case(csv.columns()[i]), names, axis);
  });
}

std::optional<Axes> axes_by_words(const CsvReader& csv, Spellings known, Spellings shorts,
                                  const std::string& what) {
  return axes_where(csv, what, [&](std::size_t i, char axis) {
    const auto name = name_along(words_of(csv, i), axis);
    return name && ends_with_word(*name, known, shorts);
  });
}

// The unit of a column in brackets, or behind its name (gyro_x_dps).
std::string unit_of_vector(const CsvReader& csv, std::size_t column) {
  std::string unit = bracketed_unit(csv, column);
  return unit.empty() ? without_unit(words_of(csv, column)).second : unit;
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

VectorColumns with_unit(const CsvReader& csv, const Axes& axes, const QuantityUnits& quantity) {
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

// gx, gy, gz, also with a unit behind the name.
std::optional<Axes> axes_of_g(const CsvReader& csv, const std::string& what) {
  const auto axes = axes_spelled(csv, kGNames, what);
  return axes ? axes : axes_by_words(csv, {}, kShortG, what);
}

// rx, ry, rz: rotation rates, where gx, gy, gz are there too, or by their unit.
std::optional<Axes> axes_of_r(const CsvReader& csv, const std::string& what) {
  constexpr std::array<std::string_view, 2> kNames{"r", "r_"};
  const auto axes = axes_spelled(csv, kNames, what);
  if (!axes) return std::nullopt;
  const std::string unit = bracketed_unit(csv, axes->front());
  const bool rate =
      std::ranges::any_of(kRateUnits, [&](const UnitFactor& u) { return u.unit == unit; });
  return rate || axes_of_g(csv, what) ? axes : std::nullopt;
}

[[noreturn]] void no_rates(const CsvReader& csv, const std::string& what) {
  for (const char axis : {'x', 'y', 'z'}) {  // the first one that is missing
    const auto column = only_column(csv, what, [&](std::size_t i) {
      return spelled(lower_case(csv.columns()[i]), kRateNames, axis);
    });
    if (!column) unknown_names(csv, fmt::format("the {} about or along {}", what, axis));
  }
  unknown_names(csv, "the " + what);
}

void find_rates(const CsvReader& csv, ImuColumns& found) {
  const std::string what = "angular rate";
  std::vector<std::string_view> others(kRateNames.begin(), kRateNames.end());
  std::erase_if(others, [](std::string_view name) { return name == "g" || name == "g_"; });
  const auto g = axes_of_g(csv, what);
  std::optional<Axes> rate = axes_spelled(csv, others, what);
  if (!rate) rate = axes_by_words(csv, kRateWords, kShortRates, what);
  if (!rate) rate = axes_of_r(csv, what);
  if (g && rate) found.gravity = VectorColumns{.columns = *g};
  if (!rate) rate = g;
  if (!rate) no_rates(csv, what);
  found.rate = with_unit(
      csv, *rate, {.units = kRateUnits, .foreign = kForceUnits, .expected = "rad/s or deg/s"});
}

void find_forces(const CsvReader& csv, ImuColumns& found) {
  const std::string what = "specific force";
  std::optional<Axes> force = axes_spelled(csv, kForceNames, what);
  if (!force) force = axes_by_words(csv, kForceWords, kShortForces, what);
  if (!force) unknown_names(csv, fmt::format("the {} about or along x", what));
  found.force = with_unit(csv, *force,
                          {.units = kForceUnits, .foreign = kRateUnits, .expected = "m/s^2 or g"});
}

// ---- times

constexpr std::array<std::string_view, 9> kTimeNames{
    "time_ns", "timestamp", "timestamp_ns", "timestamps",        "ts",
    "t",       "time",      "stamp",        "field.header.stamp"};
// Others, the better ones first: the stamp of the sensor comes before the time of recording.
constexpr std::array<std::string_view, 17> kTimeWords{
    "header_stamp", "sensor_timestamp", "sensor_time",  "timestamp", "time_stamp", "stamp",
    "time",         "unix_time",        "unixtime",     "epoch",     "epoch_time", "rostime",
    "elapsed",      "elapsed_time",     "time_elapsed", "t",         "ts"};

// A name without a unit behind it, which it returns as well.
std::pair<std::string, std::optional<TimeScale>> time_name(const std::string& words) {
  const auto [before, last] = last_word(words);
  const auto scale = time_scale_named(last);
  if (!scale) return {words, std::nullopt};
  return {before.empty() ? "time" : before, scale};  // `seconds` and `sec` are times
}

bool is_fraction_name(const std::string& word) {
  const auto scale = time_scale_named(word);
  return scale && scale->digits == 0 && word != "ns";
}

// header.stamp.secs and header.stamp.nsecs.
std::optional<TimeColumn> seconds_and_nanoseconds(const CsvReader& csv, bool of_stamp) {
  for (std::size_t i = 0; i < csv.columns().size(); ++i) {
    const auto [before, last] = last_word(words_of(csv, i));
    const auto scale = time_scale_named(last);
    const bool stamp = before.ends_with("stamp");
    if (!scale || scale->digits != 9 || stamp != of_stamp) continue;
    for (std::size_t j = 0; j < csv.columns().size(); ++j) {
      const auto [other, fraction] = last_word(words_of(csv, j));
      if (other == before && is_fraction_name(fraction)) {
        return TimeColumn{.column = i, .scale = scale, .fraction = j};
      }
    }
  }
  return std::nullopt;
}

// Where names end with the words of an entry; the first entry that finds one counts.
std::optional<TimeColumn> time_by_words(const CsvReader& csv) {
  for (const std::string_view known : kTimeWords) {
    const bool any_before = known.size() > 2;
    const auto found = only_column(csv, "the time", [&](std::size_t i) {
      const std::string name = time_name(words_of(csv, i)).first;
      return name == known || (any_before && ends_in_word(name, known));
    });
    if (found)
      return TimeColumn{.column = *found, .scale = time_name(words_of(csv, *found)).second};
  }
  return std::nullopt;
}

std::optional<TimeScale> stated_scale(const CsvReader& csv, std::size_t column) {
  const std::string unit = bracketed_unit(csv, column);
  if (unit.empty()) return std::nullopt;
  const auto scale = time_scale_named(unit);
  if (scale || csv.headings()[column].find('[') == std::string::npos) return scale;
  throw InputError(fmt::format(
      "{}: the unit of {} is {}, expected a time in ns, us, ms or s up to the year 2115",
      csv.where(), csv.columns()[column], unit));
}

}  // namespace

TimeColumn find_time_column(const CsvReader& csv) {
  if (const auto pair = seconds_and_nanoseconds(csv, true)) return *pair;
  TimeColumn found;
  const auto exact = only_column(csv, "the time", [&](std::size_t i) {
    const std::string name = lower_case(csv.columns()[i]);
    return std::ranges::find(kTimeNames, std::string_view(name)) != kTimeNames.end();
  });
  if (exact) {
    found.column = *exact;
  } else if (const auto pair = seconds_and_nanoseconds(csv, false)) {
    return *pair;
  } else if (const auto other = time_by_words(csv)) {
    found = *other;
  } else {
    unknown_names(csv, "the time");
  }
  if (const auto scale = stated_scale(csv, found.column)) found.scale = scale;
  // The digits decide between nanoseconds and seconds under the name time_ns.
  if (found.scale && found.scale->digits == 0) found.scale.reset();
  return found;
}

ImuColumns find_imu_columns(const CsvReader& csv) {
  ImuColumns found{.time = find_time_column(csv), .rate = {}, .force = {}};
  find_rates(csv, found);
  find_forces(csv, found);
  return found;
}

std::optional<std::size_t> column_named(const CsvReader& csv,
                                        const std::vector<std::string>& names) {
  for (std::size_t i = 0; i < csv.columns().size(); ++i) {
    if (std::ranges::find(names, lower_case(csv.columns()[i])) != names.end()) return i;
  }
  return std::nullopt;
}

}  // namespace chasles
