#pragma once

#include <optional>
#include <string>
#include <vector>

namespace chasles {

/// A table of text. Every row should have as many cells as the header; missing cells are empty.
struct Table {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};

/// The table with columns separated by two spaces. A column whose cells are all numbers (or "-") is
/// aligned to the right, any other to the left. Widths count Unicode characters, not bytes.
std::string to_text(const Table& table);

/// The table in GitHub's Markdown, padded to be readable as text. A "|" in a cell is escaped.
std::string to_markdown(const Table& table);

/// RFC 4180 with \n as the line end: quotes only where needed.
std::string to_csv(const Table& table);

/// A number with that many digits after the point; "-" for no value and for one that is not finite.
std::string cell(std::optional<double> value, int decimals);

}  // namespace chasles
