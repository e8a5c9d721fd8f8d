#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <chasles/eval/table.hpp>

namespace chasles {
namespace {

constexpr const char* kNoValue = "-";

std::size_t width(const std::string& text) {
  // Continuation bytes of a UTF-8 character take no column.
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xc0) != 0x80;
  }));
}

bool is_number(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789.+-eE %×") == std::string::npos &&
         (text == kNoValue || text.find_first_of("0123456789") != std::string::npos);
}

const std::string& cell_at(const std::vector<std::string>& row, std::size_t column) {
  static const std::string empty;
  return column < row.size() ? row[column] : empty;
}

struct Column {
  std::size_t width = 0;
  bool right = false;
};

std::vector<Column> layout(const Table& table) {
  std::vector<Column> columns(table.header.size());
  for (std::size_t c = 0; c < columns.size(); ++c) {
    columns[c].width = width(table.header[c]);
    columns[c].right = !table.rows.empty();
    for (const auto& row : table.rows) {
      const std::string& text = cell_at(row, c);
      columns[c].width = std::max(columns[c].width, width(text));
      if (!text.empty() && !is_number(text)) columns[c].right = false;
    }
  }
  return columns;
}

std::string padded(const std::string& text, const Column& column) {
  const std::string space(column.width - std::min(column.width, width(text)), ' ');
  return column.right ? space + text : text + space;
}

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) result += c == '|' ? std::string("\\|") : std::string(1, c);
  return result;
}

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? std::string("\"\"") : std::string(1, c);
  return result + '"';
}

Table escaped(Table table) {
  for (std::string& text : table.header) text = escaped(text);
  for (auto& row : table.rows) {
    for (std::string& text : row) text = escaped(text);
  }
  return table;
}

// The cells of a row, each padded, between the separators.
std::string line(const std::vector<std::string>& row, const std::vector<Column>& columns,
                 const char* separator) {
  std::string result;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (c > 0) result += separator;
    result += padded(cell_at(row, c), columns[c]);
  }
  return result;
}

std::string without_trailing_space(std::string text) {
  text.erase(text.find_last_not_of(' ') + 1);
  return text;
}

}  // namespace

std::string to_text(const Table& table) {
  const std::vector<Column> columns = layout(table);
  std::string result = without_trailing_space(line(table.header, columns, "  ")) + '\n';
  for (const auto& row : table.rows) {
    result += without_trailing_space(line(row, columns, "  ")) + '\n';
  }
  return result;
}

std::string to_markdown(const Table& table) {
  const Table safe = escaped(table);
  const std::vector<Column> columns = layout(safe);
  std::string result = "| " + line(safe.header, columns, " | ") + " |\n|";
  for (const Column& column : columns) {
    result += std::string(column.width + 1, '-') + (column.right ? ":|" : "-|");
  }
  result += '\n';
  for (const auto& row : safe.rows) result += "| " + line(row, columns, " | ") + " |\n";
  return result;
}

std::string to_csv(const Table& table) {
  std::string result;
  const auto append = [&](const std::vector<std::string>& row) {
    for (std::size_t c = 0; c < table.header.size(); ++c) {
      if (c > 0) result += ',';
      result += quoted(cell_at(row, c));
    }
    result += '\n';
  };
  append(table.header);
  for (const auto& row : table.rows) append(row);
  return result;
}

std::string cell(std::optional<double> value, int decimals) {
  return value && std::isfinite(*value) ? fmt::format("{:.{}f}", *value, decimals) : kNoValue;
}

}  // namespace chasles
