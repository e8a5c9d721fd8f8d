#include <algorithm>
#include <array>
#include <utility>

#include <chasles/codec/text_file.hpp>
#include <chasles/codec/unit_spelling.hpp>

namespace chasles {
namespace {

using Spelling = std::pair<std::string_view, std::string_view>;
// Other spellings, in small letters; the longer ones first.
constexpr std::array kSpellings{
    Spelling{"\u00b2", "2"}, Spelling{"\u207b", "-"}, Spelling{"\u00b9", "1"},
    Spelling{"\u2212", "-"}, Spelling{"\u00b0", "deg"}, Spelling{"\u00ba", "deg"},
    Spelling{"\u00b5", "u"}, Spelling{"\u03bc", "u"}, Spelling{"\u00b7", ""},
    Spelling{"\u22c5", ""}, Spelling{"_per_", "/"}, Spelling{" per ", "/"}, Spelling{"milli-", "m"},
    Spelling{"milli", "m"}, Spelling{"micro", "u"}, Spelling{"g-force", "gforce"},
    Spelling{"standard ", ""}, Spelling{"degrees", "deg"}, Spelling{"degree", "deg"},
    Spelling{"radians", "rad"}, Spelling{"radian", "rad"}, Spelling{"rads/", "rad/"},
    Spelling{"degs/", "deg/"}, Spelling{"revolutions", "rev"}, Spelling{"revs/", "rev/"},
    Spelling{"turns/", "rev/"}, Spelling{"turn/", "rev/"}, Spelling{"metres", "m"},
    Spelling{"meters", "m"}, Spelling{"metre", "m"}, Spelling{"meter", "m"},
    Spelling{"seconds", "s"}, Spelling{"second", "s"}, Spelling{"secs", "s"}, Spelling{"sec", "s"},
    Spelling{"squared", "2"}, Spelling{"hours", "h"}, Spelling{"hour", "h"},
    Spelling{"minute", "min"}, Spelling{"feet", "ft"},
    // In Latin-1.
    Spelling{"\xb0", "deg"}, Spelling{"\xb2", "2"}, Spelling{"\xb5", "u"}};

}  // namespace

std::string plain_unit(std::string_view unit) {
  std::string text = lower_case(trimmed(unit));
  for (const auto& [spelling, plain] : kSpellings) {
    for (std::size_t at = 0; (at = text.find(spelling, at)) != std::string::npos;) {
      text.replace(at, spelling.size(), plain);
      at += plain.size();
    }
  }
  std::erase_if(text, [](char c) {
    return std::string_view(" *^._\t{}()\\$").find(c) != std::string_view::npos;
  });
  return text;
}

}  // namespace chasles
