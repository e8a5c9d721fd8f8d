#include <algorithm>
#include <cctype>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/column_names.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles {

std::string column_words(const CsvReader& csv, std::size_t column) {
  const auto is = [](int (*kind)(int), char c) { return kind(static_cast<unsigned char>(c)) != 0; };
  std::string words;
  char before = ' ';
  for (const char c : csv.columns()[column]) {
    const bool letter = is(std::isalnum, c) || (c & 0x80) != 0;
    const bool hump = is(std::isupper, c) && is(std::islower, before);  // gyroX
    if ((!letter || hump) && !words.empty() && words.back() != '_') words += '_';
    if (letter) words += c;
    before = c;
  }
  while (words.ends_with('_')) words.pop_back();
  return lower_case(words);
}

std::pair<std::string, std::string> last_word(const std::string& words) {
  const std::size_t at = words.rfind('_');
  if (at == std::string::npos) return {"", words};
  return {words.substr(0, at), words.substr(at + 1)};
}

std::string bracketed_unit(const CsvReader& csv, std::size_t column) {
  const std::string& heading = csv.headings()[column];
  for (const auto& [open, close] : {std::pair('[', ']'), std::pair('(', ')')}) {
    const std::size_t begin = heading.find(open);
    if (begin == std::string::npos) continue;
    const std::size_t end = heading.find(close, begin);
    if (end != std::string::npos) {
      return lower_case(trimmed(std::string_view(heading).substr(begin + 1, end - begin - 1)));
    }
  }
  return {};
}

void unknown_columns(const CsvReader& csv, const std::string& missing) {
  throw InputError(fmt::format(
      "{}: has the columns {}, and none is {}: expected names as time_ns,wx,wy,wz,ax,ay,az or "
      "EuRoC's (angular rates in rad/s, specific forces in m/s^2)",
      csv.where(), fmt::join(csv.headings(), ","), missing));
}

void two_columns(const CsvReader& csv, std::size_t a, std::size_t b, const std::string& what) {
  throw InputError(fmt::format("{}: both {} and {} may be {}, expected one of them", csv.where(),
                               csv.columns()[a], csv.columns()[b], what));
}

bool ends_in_word(const std::string& words, std::string_view word) {
  return words.size() > word.size() && words.ends_with(word) &&
         words[words.size() - word.size() - 1] == '_';
}

std::vector<std::size_t> columns_named(const CsvReader& csv,
                                       const std::vector<std::string>& names) {
  std::vector<std::size_t> found;
  for (const std::string& name : names) {
    for (std::size_t i = 0; i < csv.columns().size(); ++i) {
      if (lower_case(csv.columns()[i]) == name) found.push_back(i);
    }
  }
  return found;
}

}  // namespace chasles
