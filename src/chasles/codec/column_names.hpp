#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <chasles/codec/csv.hpp>

namespace chasles {

// Names of columns as people and programs write them.

/// The name of a column in small letters, without brackets, with _ between its words: gyro_x of
/// `gyroX` and `Gyro x (rad/s)`.
std::string column_words(const CsvReader& csv, std::size_t column);

/// The last word of such a name and what is before it.
std::pair<std::string, std::string> last_word(const std::string& words);

/// Whether a name of several words ends with this one.
bool ends_in_word(const std::string& words, std::string_view word);

/// The text of the first brackets behind a name, [] before (), in small letters; empty without
/// them.
std::string bracketed_unit(const CsvReader& csv, std::size_t column);

/// Throws InputError: none of the columns is `missing`.
[[noreturn]] void unknown_columns(const CsvReader& csv, const std::string& missing);

/// Throws InputError: both columns may be `what`.
[[noreturn]] void two_columns(const CsvReader& csv, std::size_t a, std::size_t b,
                              const std::string& what);

/// The only column for which `is(column)` holds; none without one. Throws InputError for two.
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

/// The columns with these names, in small letters and without brackets, in the order of the names.
std::vector<std::size_t> columns_named(const CsvReader& csv, const std::vector<std::string>& names);

}  // namespace chasles
