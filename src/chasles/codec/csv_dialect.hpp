#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace chasles {

/// How the values of a line are separated.
struct CsvDialect {
  char separator = ',';  ///< ' ': any number of blanks
  bool quotes = false;   ///< whether values may stand in double quotes
};

/// Splits a line into its values, without the blanks and quotes around them. A line of more than
/// 1000 values is not split to its end.
void split_values(std::string_view line, const CsvDialect& dialect,
                  std::vector<std::string_view>& values);
/// The same for a line of names: where blanks separate them, brackets belong to the name before
/// them, and blanks inside brackets do not count.
void split_names(std::string_view line, const CsvDialect& dialect,
                 std::vector<std::string_view>& names);
/// Whether a line of a table as other programs write it is a comment: #, % or // begins it.
bool is_comment(std::string_view line);
/// A comment's text.
std::string_view text_of_comment(std::string_view line);
inline constexpr std::size_t kMostColumns = 1000;  ///< no table has as many

/// A table as it begins: its line of names, and what comes after it.
struct CsvHeading {
  CsvDialect dialect;          ///< of the rows
  char names_separator = ',';  ///< of the names, which may be another one
  std::string_view names;      ///< without the # of a comment; empty: there is no such line
  int line = 0;                ///< its number, from 1; without names that of the first row
  std::string_view rows;       ///< what follows
  std::string_view first;      ///< the first line that is neither empty nor a comment
};

/// Finds the names of a table's columns, which may stand in a comment, and how its values are
/// separated: by commas, semicolons, tabs or blanks, in quotes or not. A line of names does not
/// begin with a number. Those separators count that make as many names as the first row has values.
/// A line `sep=;` of spreadsheets is left out.
CsvHeading find_heading(std::string_view bytes);

/// Replaces the commas inside numbers by points (0,5 becomes 0.5), from that position on. Where
/// commas separate the values, only those in double quotes.
void decimal_points(std::string& bytes, std::size_t from, char separator);

/// A text without the brackets around it: "[m]" is m.
std::string_view without_edge_brackets(std::string_view text);

/// Removes "[m]" and "(a remark)".
std::string without_brackets(std::string_view line);

}  // namespace chasles
