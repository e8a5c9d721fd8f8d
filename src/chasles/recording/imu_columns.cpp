#include <algorithm>
#include <map>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/column_names.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/imu_columns.hpp>

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
constexpr std::array<std::string_view, 18> kRateWords{"omega",
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
                                                      "angular_vel",
                                                      "gyro_rotation"};
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

// Whether a name is one of these with the axis behind it.
bool spelled(const std::string& name, Spellings names, char axis) {
  return std::ranges::any_of(names, [&](std::string_view known) {
    return name.size() == known.size() + 1 && name.starts_with(known) && name.ends_with(axis);
  });
}

// A name without its axis and unit: gyro of gyro_x_dps, gyrox and x_gyro.
std::optional<std::string> name_along(const std::string& words, char axis) {
  std::string name = without_unit(words).first;
  if (name.ends_with("_axis")) name.resize(name.size() - 5);  // gyro_x_axis
  if (name.size() > 2 && name[0] == axis && name[1] == '_') return name.substr(2);
  if (name.size() < 2 || name.back() != axis) return std::nullopt;
  name.pop_back();
  if (name.ends_with('_')) name.pop_back();
  return name;
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

// `without`: columns with a word that begins so do not count.
std::optional<Axes> axes_by_words(const CsvReader& csv, Spellings known, Spellings shorts,
                                  const std::string& what, const std::string& without = {}) {
  const auto excluded = [&](const std::string& words) {
    return !without.empty() &&
           (words.starts_with(without) || words.find("_" + without) != std::string::npos);
  };
  return axes_where(csv, what, [&](std::size_t i, char axis) {
    const auto name = name_along(column_words(csv, i), axis);
    return name && !excluded(*name) && ends_with_word(*name, known, shorts);
  });
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
  return has_rate_unit(csv, axes->front()) || axes_of_g(csv, what) ? axes : std::nullopt;
}

[[noreturn]] void no_rates(const CsvReader& csv, const std::string& what) {
  for (const char axis : {'x', 'y', 'z'}) {  // the first one that is missing
    const auto column = only_column(csv, what, [&](std::size_t i) {
      return spelled(lower_case(csv.columns()[i]), kRateNames, axis);
    });
    if (!column) unknown_columns(csv, fmt::format("the {} about or along {}", what, axis));
  }
  unknown_columns(csv, "the " + what);
}

// gyro_x, without words before it as in est_gyro_x.
bool is_plain_rate(const CsvReader& csv, std::size_t column) {
  const auto name = name_along(column_words(csv, column), 'x');
  return name && (std::ranges::find(kRateWords, std::string_view(*name)) != kRateWords.end() ||
                  std::ranges::find(kShortRates, std::string_view(*name)) != kShortRates.end());
}

void find_rates(const CsvReader& csv, ImuColumns& found) {
  const std::string what = "angular rate";
  std::vector<std::string_view> others(kRateNames.begin(), kRateNames.end());
  std::erase_if(others, [](std::string_view name) { return name == "g" || name == "g_"; });
  const auto g = axes_of_g(csv, what);
  std::optional<Axes> rate = axes_spelled(csv, others, what);
  found.rate_is_derived = !rate;
  if (!rate) rate = axes_by_words(csv, kRateWords, kShortRates, what);
  if (!rate) rate = axes_of_r(csv, what);
  if (rate && (is_plain_rate(csv, rate->front()) || has_rate_unit(csv, rate->front()))) {
    found.rate_is_derived = false;
  }
  if (g && rate) found.gravity = VectorColumns{.columns = *g};
  if (!rate) rate = g;
  if (!rate) no_rates(csv, what);
  found.rate = with_unit(csv, *rate, ImuQuantity::kRate);
}

void find_forces(const CsvReader& csv, ImuColumns& found) {
  const std::string what = "specific force";
  std::optional<Axes> force = axes_spelled(csv, kForceNames, what);
  // A phone's linear acceleration has no gravity, ROS's has.
  std::vector<std::string_view> total(kForceWords.begin(), kForceWords.end());
  std::erase_if(total, [](std::string_view word) { return word.starts_with("lin"); });
  if (!force) force = axes_by_words(csv, total, kShortForces, what, "lin");
  if (!force) force = axes_by_words(csv, kForceWords, kShortForces, what);
  if (!force) unknown_columns(csv, fmt::format("the {} about or along x", what));
  found.force = with_unit(csv, *force, ImuQuantity::kForce);
}

using Triples = std::map<std::string, Axes>;

// The columns whose names differ in x, y and z, by what their names have in common.
Triples triples_of(const CsvReader& csv) {
  std::map<std::string, std::array<std::optional<std::size_t>, 3>> found;
  for (std::size_t i = 0; i < csv.columns().size(); ++i) {
    const std::string words = column_words(csv, i), name = without_unit(words).first;
    for (std::size_t k = 0; k < 3; ++k) {
      const char axis = "xyz"[k];
      const auto stem = name == std::string(1, axis) ? "" : name_along(words, axis);
      if (stem && !found[*stem][k]) found[*stem][k] = i;
    }
  }
  Triples triples;
  for (const auto& [stem, axes] : found) {
    if (axes[0] && axes[1] && axes[2]) triples[stem] = {*axes[0], *axes[1], *axes[2]};
  }
  return triples;
}

// Whether axes are named as a quantity. `plain`: without words before it; x, y, z are as well.
bool is_named_as(const CsvReader& csv, const std::string& stem, const Axes& axes,
                 ImuQuantity quantity, bool plain) {
  const bool forces = quantity == ImuQuantity::kForce;
  const Spellings names = forces ? Spellings(kForceNames) : kRateNames,
                  words = forces ? Spellings(kForceWords) : kRateWords,
                  shorts = forces ? Spellings(kShortForces) : kShortRates;
  if (!plain) return ends_with_word(stem, words, shorts);
  const auto has = [&](Spellings list) { return std::ranges::find(list, stem) != list.end(); };
  return stem.empty() || has(words) || has(shorts) || (!forces && stem == "g") ||
         spelled(lower_case(csv.columns()[axes[0]]), names, 'x');
}

}  // namespace

ImuColumns find_imu_columns(const CsvReader& csv) {
  ImuColumns found{.time = find_time_column(csv), .rate = {}, .force = {}};
  find_rates(csv, found);
  find_forces(csv, found);
  return found;
}

Eigen::Vector3d vector_of(const CsvReader& csv, const VectorColumns& v) {
  const Eigen::Vector3d values(csv.number(v.columns[0]), csv.number(v.columns[1]),
                               csv.number(v.columns[2]));
  return v.factor == 1 ? values : Eigen::Vector3d(v.factor * values);
}

void fail_sensor_columns(const CsvReader& csv, const std::string& found) {
  throw InputError(fmt::format(
      "{}: has the columns {}: {}, expected a time and x, y and z of one sensor, as time_ns,x,y,z",
      csv.where(), fmt::join(csv.headings(), ","), found));
}

VectorColumns find_sensor_axes(const CsvReader& csv, ImuQuantity quantity) {
  const bool forces = quantity == ImuQuantity::kForce;
  const Triples triples = triples_of(csv);
  Triples mine, others;
  for (const auto& [stem, axes] : triples) {
    if (is_named_as(csv, stem, axes, quantity, true)) mine.emplace(stem, axes);
    if (is_named_as(csv, stem, axes, quantity, false)) others.emplace(stem, axes);
  }
  if (mine.empty()) mine = others;
  if (mine.empty() && triples.size() == 1) mine = triples;
  if (mine.empty()) fail_sensor_columns(csv, "no three are its axes");
  if (mine.size() > 1) fail_sensor_columns(csv, "several may be its axes");
  const auto& [stem, axes] = *mine.begin();
  const auto other = forces ? ImuQuantity::kRate : ImuQuantity::kForce;
  const bool of_g = stem == "g";
  if (!stem.empty() && !of_g && is_named_as(csv, stem, axes, other, true) &&
      !is_named_as(csv, stem, axes, quantity, false)) {
    fail_sensor_columns(csv, fmt::format("{}, … are those of the {}", csv.columns()[axes[0]],
                                         forces ? "gyroscope" : "accelerometer"));
  }
  return with_unit(csv, axes, quantity);
}

}  // namespace chasles
