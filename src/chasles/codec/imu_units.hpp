#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <chasles/codec/csv.hpp>

namespace chasles {

/// Three columns of a vector, x, y and z, and the factor that makes SI units of its numbers.
struct VectorColumns {
  std::array<std::size_t, 3> columns{};
  double factor = 1;
  std::string unit = {};  ///< as the name states it, in small letters; empty: none
};

enum class ImuQuantity { kRate, kForce };

/// The columns with the unit that their names state, in brackets or at their end (gyro_x_dps), in
/// any usual spelling; without one rad/s and m/s^2. Throws InputError for units that are not known,
/// as those of other quantities and raw counts, and where the three units differ.
VectorColumns with_unit(const CsvReader& csv, const std::array<std::size_t, 3>& axes,
                        ImuQuantity quantity);

/// What makes SI units of a quantity in this unit, in any usual spelling; 1 for an empty one, none
/// for one that is not known.
std::optional<double> factor_of_unit(std::string_view unit, ImuQuantity quantity);

/// Whether the name of a column states a unit of angular rates in brackets.
bool has_rate_unit(const CsvReader& csv, std::size_t column);

/// A name of an axis (column_words()) without a unit at its end, and that unit; empty without one.
/// gFx is acc_x in g.
std::pair<std::string, std::string> without_unit(const std::string& words);

}  // namespace chasles
