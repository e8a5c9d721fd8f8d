#include <algorithm>
#include <cctype>
#include <charconv>

#include <chasles/data/csv_dialect.hpp>
#include <chasles/data/text_file.hpp>

namespace chasles {
namespace {

// A comment that may hold the names.
struct HeadingLine {
  std::string_view names;
  int line = 0;
  std::string_view rows;
};

std::string_view without_quotes(std::string_view text) {
  const bool quoted = text.size() >= 2 && text.front() == '"' && text.back() == '"';
  return quoted ? trimmed(text.substr(1, text.size() - 2)) : text;
}

// Where a value ends. A separator within quotes does not count.
std::size_t value_end(std::string_view line, const CsvDialect& dialect) {
  const std::size_t begin = line.find_first_not_of(' ');
  if (dialect.quotes && begin != std::string_view::npos && line[begin] == '"') {
    const std::size_t close = line.find('"', begin + 1);
    if (close != std::string_view::npos) return line.find(dialect.separator, close + 1);
  }
  return line.find(dialect.separator);
}

std::size_t count_values(std::string_view line, char separator) {
  std::vector<std::string_view> values;
  split_values(line, {.separator = separator, .quotes = true}, values);
  return values.size();
}

bool begins_with_number(std::string_view line, char separator) {
  std::vector<std::string_view> values;
  split_values(line, {.separator = separator, .quotes = true}, values);
  std::string text(values.empty() ? std::string_view() : values.front());
  if (separator != ',') std::replace(text.begin(), text.end(), ',', '.');
  double ignored = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, ignored);
  return error != std::errc::invalid_argument && stop == end && !text.empty();
}

char first_of(std::string_view line, std::string_view separators) {
  for (const char c : separators) {
    if (line.find(c) != std::string_view::npos) return c;
  }
  return line.find_first_of(" \t") == std::string_view::npos ? ',' : ' ';
}

// Of a row of numbers commas may be decimal; of names a semicolon may be part of one.
char separator_of_row(std::string_view line) { return first_of(line, ";\t,"); }
char separator_of_names(std::string_view line) { return first_of(without_brackets(line), ",;\t"); }

// The comment with one name for each value of the first row; else one with commas.
const HeadingLine* names_among(const std::vector<HeadingLine>& comments, std::size_t values,
                               char separator) {
  for (const HeadingLine& comment : comments) {
    if (count_values(comment.names, separator) == values && values > 1) return &comment;
  }
  for (const HeadingLine& comment : comments) {
    if (comment.names.find(',') != std::string_view::npos && separator == ',') return &comment;
  }
  return nullptr;
}

}  // namespace

void split_values(std::string_view line, const CsvDialect& dialect,
                  std::vector<std::string_view>& values) {
  values.clear();
  const auto add = [&](std::string_view value) {
    values.push_back(dialect.quotes ? without_quotes(trimmed(value)) : trimmed(value));
  };
  if (dialect.separator == ' ') {
    for (line = trimmed(line); !line.empty() && values.size() <= kMostColumns;) {
      const std::size_t end = std::min(line.find_first_of(" \t"), line.size());
      add(line.substr(0, end));
      line = trimmed(line.substr(end));
    }
    return;
  }
  for (std::size_t end = 0; values.size() < kMostColumns &&
                            (end = value_end(line, dialect)) != std::string_view::npos;) {
    add(line.substr(0, end));
    line.remove_prefix(end + 1);
  }
  add(line);
}

CsvHeading find_heading(std::string_view bytes) {
  CsvHeading heading{
      .dialect = {.quotes = true}, .names = {}, .line = 0, .rows = bytes, .first = {}};
  std::vector<HeadingLine> comments;
  while (!heading.rows.empty()) {
    ++heading.line;
    const std::string_view line = take_line(heading.rows);
    const std::string_view text = trimmed(line);
    if (text.starts_with('#')) {
      comments.push_back({trimmed(text.substr(1)), heading.line, heading.rows});
    } else if (!text.empty()) {
      heading.first = line;
      break;
    }
  }
  const char of_row = separator_of_row(heading.first), of_names = separator_of_names(heading.first);
  const bool number = begins_with_number(heading.first, of_row);
  heading.dialect.separator = number || heading.first.empty() ? of_row : of_names;
  const HeadingLine* comment = names_among(
      comments, count_values(heading.first, heading.dialect.separator), heading.dialect.separator);
  const bool named = !number && !heading.first.empty();
  if (named && comment != nullptr &&
      (heading.dialect.separator != ',' ||
       count_values(comment->names, ',') != count_values(heading.first, ','))) {
    comment = nullptr;  // prose above the names
  }
  if (comment != nullptr) {
    heading.names = comment->names;
    heading.line = comment->line;
    heading.rows = comment->rows;
  } else if (!number) {
    heading.names = heading.first;
  }
  return heading;
}

void decimal_points(std::string& bytes, std::size_t from) {
  const auto digit = [&](std::size_t i) {
    return i < bytes.size() && std::isdigit(static_cast<unsigned char>(bytes[i])) != 0;
  };
  for (std::size_t i = std::max<std::size_t>(from, 1); i < bytes.size(); ++i) {
    if (bytes[i] == ',' && digit(i - 1) && digit(i + 1)) bytes[i] = '.';
  }
}

std::string without_brackets(std::string_view line) {
  std::string text;
  int depth = 0;
  for (const char c : line) {
    if (c == '[' || c == '(') ++depth;
    if (depth == 0) text += c;
    if (c == ']' || c == ')') depth = std::max(depth - 1, 0);
  }
  return text;
}

}  // namespace chasles
