#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <chasles/base/time.hpp>
#include <chasles/codec/csv_dialect.hpp>

namespace chasles {

/// What a last line without a line end means.
enum class LastLine {
  /// It is a row if it looks whole: many programs write no line end there. If not, the file was
  /// truncated, as when a robot loses its power, and the line is left out. Readers add
  /// remark_on_open_end().
  kMayBeOpen,
  /// The file is truncated. For files that this program wrote.
  kMustEnd,
};

/// Adds a remark if the last line of a plain file has no line end. Nothing for a missing file.
void remark_on_open_end(const std::filesystem::path& file, std::vector<std::string>& remarks);

/// Reads a table of comma-separated values row by row. The first line has the names of the columns.
/// Empty lines and lines that start with # are skipped, and so is a byte-order mark. There is no
/// quoting. Errors name file, line and column.
class CsvReader {
 public:
  /// Accepts any columns. Throws InputError for a file without a first line, or that is truncated.
  explicit CsvReader(const std::filesystem::path& file, LastLine last = LastLine::kMustEnd);
  /// The same for bytes that were read; `file` names the table in messages.
  CsvReader(std::string file, std::string bytes, LastLine last);
  /// Throws InputError unless the columns are exactly these, or these and then the further ones.
  CsvReader(const std::filesystem::path& file, const std::vector<std::string>& columns,
            const std::vector<std::string>& further = {}, LastLine last = LastLine::kMayBeOpen);

  /// A table whose first line is a comment with the names of the columns, as in EuRoC files. Units
  /// in brackets are not part of a name. Throws InputError unless the names are one of the `known`
  /// lists. `file` names the table in messages.
  CsvReader(std::string file, std::string bytes,
            const std::vector<std::vector<std::string>>& known);

  /// A table with any columns, as other programs write it: its line of names is a comment or not,
  /// and commas, semicolons, tabs or blanks separate the values, which may stand in quotes
  /// (find_heading()). Where the separator is no comma, and in quotes, 0,5 is the number 0.5. A
  /// line of units below the names counts as brackets behind them. `file` names the table in
  /// messages. Throws InputError if there is no line of names.
  CsvReader(std::string file, std::string bytes);

  /// The same for a table that has no line of names: `names` are those of its columns.
  struct NoHeading {
    CsvDialect dialect = {.quotes = true};
  };
  CsvReader(std::string file, std::string bytes, NoHeading, const std::vector<std::string>& names);

  const std::vector<std::string>& columns() const { return columns_; }
  /// Of a table with any columns: the names as they stand there, with units in brackets, also those
  /// of a line below them.
  const std::vector<std::string>& headings() const { return headings_; }

  /// Moves to the next row; false at the end. Throws InputError if the row has too few or too many
  /// values, but for a last line without a line end.
  bool next();

  double number(std::size_t column) const;  ///< "nan" and "inf" too
  double finite(std::size_t column) const;
  std::int64_t integer(std::size_t column) const;
  Time time(std::size_t column) const;  ///< from nanoseconds
  std::string_view text(std::size_t column) const { return values_[column]; }

  /// Throws InputError if the last line was left out. For tables whose readers have no remarks.
  void require_whole() const;
  int line() const { return line_; }  ///< of the row, from 1
  /// "FILE:LINE".
  std::string where() const;
  /// "FILE:LINE: column 'NAME'".
  std::string where(std::size_t column) const;

 private:
  void split_names(std::string_view line);
  std::string_view next_line();
  void check_end(LastLine last);
  void reject_utf16() const;
  void read_columns(const CsvHeading& heading);
  void take_units();
  bool is_blank_row(std::string_view line) const;

  std::string file_;
  std::string bytes_;
  std::string_view rest_;
  int line_ = 0;
  bool torn_ = false;
  CsvDialect dialect_;
  std::vector<std::string> columns_, headings_;
  std::vector<std::string_view> values_;
};

}  // namespace chasles
