#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <chasles/time.hpp>

namespace chasles {

/// Reads a table of comma-separated values row by row. The first line has the names of the columns.
/// Empty lines and lines that start with # are skipped. There is no quoting. A last line without a
/// line end means that the file is truncated. Errors name file, line and column.
class CsvReader {
 public:
  /// Accepts any columns. Throws InputError for a file without a first line, or without a line end
  /// at its end.
  explicit CsvReader(const std::filesystem::path& file);
  /// Throws InputError unless the columns are exactly these, or these and then the further ones.
  CsvReader(const std::filesystem::path& file, const std::vector<std::string>& columns,
            const std::vector<std::string>& further = {});

  /// A table whose first line is a comment with the names of the columns, as in EuRoC files. Units
  /// in brackets are not part of a name. Throws InputError unless the names are one of the `known`
  /// lists. `file` names the table in messages.
  CsvReader(std::string file, std::string bytes,
            const std::vector<std::vector<std::string>>& known);

  const std::vector<std::string>& columns() const { return columns_; }

  /// Moves to the next row; false at the end. Throws InputError if the row has too few or too many
  /// values.
  bool next();

  double number(std::size_t column) const;  ///< "nan" and "inf" too
  double finite(std::size_t column) const;
  std::int64_t integer(std::size_t column) const;
  Time time(std::size_t column) const;  ///< from nanoseconds
  std::string_view text(std::size_t column) const { return values_[column]; }

  /// "FILE:LINE".
  std::string where() const;
  /// "FILE:LINE: column 'NAME'".
  std::string where(std::size_t column) const;

 private:
  std::string_view next_line();
  void check_end() const;

  std::string file_;
  std::string bytes_;
  std::string_view rest_;
  int line_ = 0;
  std::vector<std::string> columns_;
  std::vector<std::string_view> values_;
};

}  // namespace chasles
