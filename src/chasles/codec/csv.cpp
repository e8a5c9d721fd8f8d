#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/csv.hpp>
#include <chasles/codec/imu_units.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/time_text.hpp>

namespace chasles {
namespace {

template <typename Number>
bool parse_fast(std::string_view text, Number& value) {
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end;
}

bool is_unit(std::string_view text) {
  const std::string unit = lower_case(text);
  return !unit.empty() && (time_scale_named(unit) || factor_of_unit(unit, ImuQuantity::kRate) ||
                           factor_of_unit(unit, ImuQuantity::kForce));
}

// "units: s, rad/s" without the word before the units.
std::string_view without_title(std::string_view line) {
  const std::size_t colon = line.find(':');
  const bool titled = colon < 10 && lower_case(line.substr(0, colon)).starts_with("unit");
  return titled ? trimmed(line.substr(colon + 1)) : line;
}

// Whether a line below the names has their units: some are known, and none is a number but 1.
bool are_units(const std::vector<std::string_view>& values, bool comment) {
  const auto number = [](std::string_view text) {
    double ignored = 0;
    return text != "1" && parse_fast(text, ignored);
  };
  const auto known = [](std::string_view text) { return is_unit(without_edge_brackets(text)); };
  const auto other = [&](std::string_view text) {
    return comment && !text.empty() && text != "-" && text != "1" && !known(text);
  };
  return std::ranges::any_of(values, known) && std::ranges::none_of(values, number) &&
         std::ranges::none_of(values, other);
}

}  // namespace

void remark_on_open_end(const std::filesystem::path& file, std::vector<std::string>& remarks) {
  std::ifstream stream(file, std::ios::binary);
  const bool gzip = stream.get() == 0x1f && stream.get() == 0x8b;  // it has a check sum
  if (!stream || gzip || !stream.seekg(-1, std::ios::end) || stream.get() == '\n') return;
  remarks.push_back(fmt::format(
      "the last line of {} has no line end, and is left out if it is not whole: the file "
      "may be truncated",
      (file.parent_path().filename() / file.filename()).string()));
}

CsvReader::CsvReader(const std::filesystem::path& file, LastLine last)
    : CsvReader(file.string(), read_text(file), last) {}

CsvReader::CsvReader(std::string file, std::string bytes, LastLine last)
    : file_(std::move(file)), bytes_(std::move(bytes)), rest_(bytes_) {
  split_names(next_line());
  if (values_.size() == 1 && values_[0].empty()) {
    throw InputError(
        fmt::format("{}: is empty, expected a line with the names of the columns", file_));
  }
  check_end(last);
  columns_.assign(values_.begin(), values_.end());
}

// A number that ends with a sign or a point was longer.
void CsvReader::check_end(LastLine last) {
  if (bytes_.empty()) return;  // a table without names and rows
  const bool whole = std::string_view(".,+-").find(bytes_.back()) == std::string_view::npos;
  if (bytes_.back() == '\n' || (last == LastLine::kMayBeOpen && whole)) return;
  const std::size_t end = rest_.rfind('\n');
  if (last == LastLine::kMayBeOpen && end != std::string_view::npos) {
    rest_ = rest_.substr(0, end + 1);
    torn_ = true;
    return;
  }
  throw InputError(fmt::format(
      "{}: its last line has no line end: the file is truncated (if not, add a line end)", file_));
}

CsvReader::CsvReader(const std::filesystem::path& file, const std::vector<std::string>& columns,
                     const std::vector<std::string>& further, LastLine last)
    : CsvReader(file, last) {
  if (columns_ == columns) return;
  std::vector<std::string> all = columns;
  all.insert(all.end(), further.begin(), further.end());
  if (columns_ == all) return;
  throw InputError(
      fmt::format("{}: has the columns {}, expected {}{}", where(), fmt::join(columns_, ","),
                  fmt::join(columns, ","),
                  line_ > 1 ? " (the lines before, which begin with #, are comments)" : ""));
}

CsvReader::CsvReader(std::string file, std::string bytes,
                     const std::vector<std::vector<std::string>>& known)
    : file_(std::move(file)), bytes_(std::move(bytes)), line_(1) {
  remove_byte_order_mark(bytes_);
  rest_ = bytes_;
  const std::string_view line = take_line(rest_);
  if (!line.starts_with('#')) {
    throw InputError(
        fmt::format("{}: begins with '{:.40}', expected a line # with the names of the columns",
                    where(), line));
  }
  check_end(LastLine::kMayBeOpen);
  const std::string names = without_brackets(line.substr(1));
  split_names(names);
  columns_.assign(values_.begin(), values_.end());
  if (std::find(known.begin(), known.end(), columns_) != known.end()) return;
  std::string expected;
  for (const auto& list : known) {
    expected += fmt::format("{}{}", expected.empty() ? "" : " or ", fmt::join(list, ","));
  }
  throw InputError(fmt::format("{}: has the columns {}, expected {}", where(),
                               fmt::join(columns_, ","), expected));
}

void CsvReader::reject_utf16() const {
  if (!bytes_.starts_with("\xff\xfe") && !bytes_.starts_with("\xfe\xff")) return;
  throw InputError(fmt::format(
      "{}: is text in UTF-16, expected UTF-8: save it as \"CSV UTF-8\" in the spreadsheet", file_));
}

void CsvReader::read_columns(const CsvHeading& heading) {
  line_ = heading.line;
  rest_ = heading.rows;
  dialect_ = {.separator = heading.names_separator, .quotes = true};
  split_names(heading.names);
  headings_.assign(values_.begin(), values_.end());
  for (const std::string& name : headings_) columns_.emplace_back(trimmed(without_brackets(name)));
  if (columns_.size() > 1 && headings_.back().empty()) {  // the line ends with a separator
    columns_.pop_back();
    headings_.pop_back();
  }
  take_units();
  dialect_ = heading.dialect;
  const auto from = static_cast<std::size_t>(rest_.data() - bytes_.data());
  decimal_points(bytes_, from, dialect_.separator);
  rest_ = std::string_view(bytes_).substr(from, rest_.size());
}

// Of a line of units below the names.
void CsvReader::take_units() {
  std::string_view rest = rest_, line;
  int lines = 0;
  for (; !rest.empty() && line.empty(); ++lines) line = trimmed(take_line(rest));
  const bool comment = is_comment(line);
  if (comment) line = without_title(text_of_comment(line));
  std::vector<std::string_view> units;
  chasles::split_names(line, dialect_, units);
  if (units.size() == columns_.size() + 1 && units.back().empty()) units.pop_back();
  if (units.size() != columns_.size() || !are_units(units, comment)) return;
  for (std::size_t i = 0; i < units.size(); ++i) {
    const std::string_view unit = without_edge_brackets(units[i]);
    if (headings_[i] == columns_[i] && !unit.empty()) headings_[i] += fmt::format(" [{}]", unit);
  }
  rest_ = rest;
  line_ += lines;
}

CsvReader::CsvReader(std::string file, std::string bytes)
    : file_(std::move(file)), bytes_(std::move(bytes)) {
  reject_utf16();
  remove_byte_order_mark(bytes_);
  const CsvHeading heading = find_heading(bytes_);
  if (heading.names.empty()) {
    line_ = heading.line;
    throw InputError(
        fmt::format("{}: begins with '{:.40}', expected a line with the names of the columns",
                    where(), heading.first));
  }
  rest_ = heading.rows;
  check_end(LastLine::kMayBeOpen);
  read_columns({.dialect = heading.dialect,
                .names_separator = heading.names_separator,
                .names = heading.names,
                .line = heading.line,
                .rows = rest_,
                .first = heading.first});
}

CsvReader::CsvReader(std::string file, std::string bytes, NoHeading form,
                     const std::vector<std::string>& names)
    : file_(std::move(file)),
      bytes_(std::move(bytes)),
      dialect_(form.dialect),
      columns_(names),
      headings_(names) {
  remove_byte_order_mark(bytes_);
  decimal_points(bytes_, 0, dialect_.separator);
  rest_ = bytes_;
  check_end(LastLine::kMayBeOpen);
}

void CsvReader::split_names(std::string_view line) {
  chasles::split_names(line, dialect_, values_);
  if (values_.size() <= kMostColumns) return;
  throw InputError(fmt::format("{}: has more than {} columns, expected a table of numbers", where(),
                               kMostColumns));
}

// Spreadsheets write rows of separators below a table.
bool CsvReader::is_blank_row(std::string_view line) const {
  if (line.size() > kMostColumns) return false;
  return line.find_first_not_of(" \t") == std::string_view::npos ||
         (dialect_.separator != ' ' &&
          std::ranges::all_of(line, [this](char c) { return c == dialect_.separator; }));
}

std::string_view CsvReader::next_line() {
  while (!rest_.empty()) {
    ++line_;
    const std::string_view line = take_line(rest_);
    const bool comment = dialect_.quotes ? is_comment(line) || is_blank_row(line)
                                         : !line.empty() && line.front() == '#';
    if (!line.empty() && !comment) return line;
  }
  return {};
}

bool CsvReader::next() {
  const std::string_view line = next_line();
  if (line.empty()) return false;
  split_values(line, dialect_, values_);
  // Spreadsheets end lines with a separator.
  if (dialect_.quotes && values_.size() == columns_.size() + 1 && values_.back().empty()) {
    values_.pop_back();
  }
  if (values_.size() == columns_.size()) return true;
  const bool open = rest_.empty() && bytes_.back() != '\n';
  torn_ = open && values_.size() < columns_.size();
  if (torn_) return false;
  throw InputError(fmt::format("{}: has {} values, expected {}: {}", where(), values_.size(),
                               columns_.size(), fmt::join(columns_, ",")));
}

void CsvReader::require_whole() const {
  if (!torn_) return;
  throw InputError(fmt::format(
      "{}: its last line is not whole: the file is truncated, expected a line end", file_));
}

double CsvReader::number(std::size_t column) const {
  double value = 0;
  return parse_fast(values_[column], value) ? value : parse_number(where(column), values_[column]);
}

double CsvReader::finite(std::size_t column) const {
  double value = 0;
  if (parse_fast(values_[column], value) && std::isfinite(value)) return value;
  return parse_finite(where(column), values_[column]);
}

std::int64_t CsvReader::integer(std::size_t column) const {
  std::int64_t value = 0;
  return parse_fast(values_[column], value) ? value : parse_integer(where(column), values_[column]);
}

Time CsvReader::time(std::size_t column) const {
  std::int64_t value = 0;
  const bool read =
      parse_fast(values_[column], value) && value > -kLastNanosecond && value < kLastNanosecond;
  return read ? Time(value) : parse_nanoseconds(where(column), values_[column]);
}

std::string CsvReader::where() const { return fmt::format("{}:{}", file_, line_); }

std::string CsvReader::where(std::size_t column) const {
  return fmt::format("{}: column '{}'", where(), columns_[column]);
}

}  // namespace chasles
