#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>
#include <utility>

#include <chasles/codec/csv_dialect.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles {
namespace {

// A comment that may hold the names.
struct HeadingLine {
  std::string_view names;
  int line = 0;
  std::string_view rows;
  char separator = ',';
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

std::size_t count_names(std::string_view line, char separator) {
  std::vector<std::string_view> names;
  split_names(line, {.separator = separator, .quotes = true}, names);
  return names.size();
}

bool is_number_text(std::string_view value, char separator) {
  std::string text(value);
  if (text.starts_with(',') || text.ends_with(',')) return false;
  if (separator != ',') std::replace(text.begin(), text.end(), ',', '.');
  double ignored = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, ignored);
  return error != std::errc::invalid_argument && stop == end && !text.empty();
}

bool begins_with_number(std::string_view line, char separator) {
  std::vector<std::string_view> values;
  split_values(line, {.separator = separator, .quotes = true}, values);
  return is_number_text(values.empty() ? std::string_view() : values.front(), separator);
}

char first_of(std::string_view line, std::string_view separators) {
  for (const char c : separators) {
    if (line.find(c) != std::string_view::npos) return c;
  }
  return line.find_first_of(" \t") == std::string_view::npos ? ',' : ' ';
}

// Where a name of a line without blanks at its ends is over, if blanks separate the names.
std::size_t name_end(std::string_view line) {
  const auto opens = [](char c) { return c == '[' || c == '('; };
  std::size_t depth = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (opens(line[i])) ++depth;
    if ((line[i] == ']' || line[i] == ')') && depth > 0) --depth;
    if (depth > 0 || (line[i] != ' ' && line[i] != '\t')) continue;
    const std::size_t next = line.find_first_not_of(" \t", i);
    if (!opens(line[next]) || opens(line.front())) return i;
    i = next - 1;  // a unit belongs to the name before it, but not to another unit
  }
  return line.size();
}

// "1,\t2,\t3": the tabs only make columns for the eye.
bool tabs_follow_commas(std::string_view line) {
  line = trimmed(line);
  for (std::size_t tab = 0; (tab = line.find('\t', tab)) != std::string_view::npos;) {
    const std::size_t before = line.find_last_not_of(" \t", tab),
                      after = line.find_first_not_of(" \t", tab);
    if (line[before] != ',' && line[after] != ',') return false;
    tab = after;
  }
  return line.find('\t') != std::string_view::npos;
}

// "0,5 1,5 2,5": blanks separate numbers with decimal commas.
bool blanks_separate(std::string_view line) {
  std::vector<std::string_view> values;
  split_values(line, {.separator = ' ', .quotes = true}, values);
  return values.size() > 1 && std::ranges::all_of(values, [](std::string_view value) {
           return is_number_text(value, ' ');
         });
}

// Of a row of numbers commas may be decimal; of names a semicolon may be part of one.
char separator_of_row(std::string_view line) {
  const char found = first_of(line, ";\t,");
  if (found == '\t' && tabs_follow_commas(line)) return ',';
  if (found == '\t' && count_values(line, ' ') <= count_values(line, '\t')) return found;
  return found != ';' && blanks_separate(line) ? ' ' : found;
}
char separator_of_names(std::string_view line) { return first_of(without_brackets(line), ",;\t"); }

// The separator, that of the rows first, which makes as many names; none without one.
std::optional<char> separator_of_count(std::string_view names, std::size_t count, char of_rows) {
  for (const char separator : {of_rows, ',', ';', '\t', ' '}) {
    if (count > 1 && count_names(names, separator) == count) return separator;
  }
  return std::nullopt;
}

// The comment with one name for each value of the first row; else one with commas; else one whose
// names are separated in another way.
std::optional<HeadingLine> names_among(std::vector<HeadingLine>& comments, std::size_t values,
                                       char separator) {
  for (HeadingLine& comment : comments) {
    comment.separator = separator;
    if (count_names(comment.names, separator) == values && values > 1) return comment;
  }
  for (const HeadingLine& comment : comments) {
    if (comment.names.find(',') != std::string_view::npos && separator == ',') return comment;
  }
  for (HeadingLine& comment : comments) {
    const auto other = separator_of_count(comment.names, values, separator);
    if (other) comment.separator = *other;
    if (other) return comment;
  }
  return std::nullopt;
}

std::string_view first_row(std::string_view rows) {
  std::string_view row;
  while (!rows.empty() && (row.empty() || is_comment(row))) row = trimmed(take_line(rows));
  return is_comment(row) ? std::string_view() : row;
}

// The separators of names and of the rows below: those that make as many names as the first row has
// values; both that of the names if none do.
std::pair<char, char> separators_of(std::string_view names, std::string_view rows) {
  const char of_names = separator_of_names(names);
  const std::string_view row = first_row(rows);
  for (const char separator : {of_names, ';', '\t', ',', ' '}) {
    const std::size_t count = count_names(names, separator), values = count_values(row, separator);
    const bool ended = values == count + 1 && row.ends_with(separator);  // as spreadsheets do it
    if (count > 1 && (count == values || ended)) return {separator, separator};
  }
  const char of_row = separator_of_row(row);
  const bool numbers = begins_with_number(row, of_row);
  const auto other = separator_of_count(names, count_values(row, of_row), of_row);
  return numbers && other ? std::pair(*other, of_row) : std::pair(of_names, of_names);
}

// The line by which spreadsheets state the separator.
bool states_separator(std::string_view text) {
  return text.size() <= 5 && lower_case(text).starts_with("sep=");
}

// The comments above the first line that is neither empty nor a comment, which `heading` takes.
std::vector<HeadingLine> read_to_first_line(CsvHeading& heading) {
  std::vector<HeadingLine> comments;
  while (!heading.rows.empty()) {
    ++heading.line;
    const std::string_view line = take_line(heading.rows);
    const std::string_view text = trimmed(line);
    if (is_comment(text)) {
      comments.push_back({text_of_comment(text), heading.line, heading.rows});
    } else if (!text.empty() && !states_separator(text)) {
      heading.first = line;
      break;
    }
  }
  return comments;
}

}  // namespace

bool is_comment(std::string_view line) {
  return line.starts_with('#') || line.starts_with('%') || line.starts_with("//");
}

std::string_view text_of_comment(std::string_view line) {
  return trimmed(line.substr(line.starts_with("//") ? 2 : 1));
}

void split_names(std::string_view line, const CsvDialect& dialect,
                 std::vector<std::string_view>& names) {
  if (dialect.separator != ' ') return split_values(line, dialect, names);
  names.clear();
  for (line = trimmed(line); !line.empty() && names.size() <= kMostColumns;) {
    const std::size_t end = name_end(line);
    names.push_back(without_quotes(trimmed(line.substr(0, end))));
    line = trimmed(line.substr(end));
  }
}

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
  std::vector<HeadingLine> comments = read_to_first_line(heading);
  const char of_row = separator_of_row(heading.first);
  const bool number = begins_with_number(heading.first, of_row);
  const bool named = !number && !heading.first.empty();
  const auto [of_names, below] =
      named ? separators_of(heading.first, heading.rows) : std::pair(of_row, of_row);
  heading.dialect.separator = below;
  heading.names_separator = of_names;
  const std::size_t values =
      named ? count_names(heading.first, of_names) : count_values(heading.first, of_row);
  auto comment = names_among(comments, values, of_names);
  if (named && comment &&
      (of_names != ',' || count_values(comment->names, ',') != count_values(heading.first, ','))) {
    comment.reset();  // prose above the names
  }
  if (comment) {
    heading.names = comment->names;
    heading.line = comment->line;
    heading.rows = comment->rows;
    heading.names_separator = comment->separator;
  } else if (!number) {
    heading.names = heading.first;
  }
  return heading;
}

void decimal_points(std::string& bytes, std::size_t from, char separator) {
  const auto digit = [&](std::size_t i) {
    return i < bytes.size() && std::isdigit(static_cast<unsigned char>(bytes[i])) != 0;
  };
  bool quoted = false;
  for (std::size_t i = std::max<std::size_t>(from, 1); i < bytes.size(); ++i) {
    if (bytes[i] == '"') quoted = !quoted;
    if (bytes[i] == '\n') quoted = false;
    if (bytes[i] != ',' || !digit(i + 1) || (separator == ',' && !quoted)) continue;
    const bool begins = std::string_view(";\t \n\"+-").find(bytes[i - 1]) != std::string_view::npos;
    if (digit(i - 1) || begins) bytes[i] = '.';  // 0,5 and ,5
  }
}

std::string_view without_edge_brackets(std::string_view text) {
  const bool square = text.starts_with('[') && text.ends_with(']');
  const bool round = text.starts_with('(') && text.ends_with(')');
  return square || round ? trimmed(text.substr(1, text.size() - 2)) : text;
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
