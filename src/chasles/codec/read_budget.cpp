#include <charconv>
#include <cstdlib>
#include <limits>
#include <string_view>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/read_budget.hpp>

namespace chasles {
namespace {

constexpr const char* kMemoryVariable = "CHASLES_READ_MEMORY";
constexpr const char* kDepthVariable = "CHASLES_READ_DEPTH";
constexpr std::size_t kMostDepth = 10'000;  // the stack of a reader

// A whole number with a unit of 1024; 0 for another text.
std::size_t size_of(std::string_view text) {
  static constexpr std::string_view kUnits = "KMG";
  std::size_t value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc()) return 0;
  if (stop == end) return value;
  const std::size_t unit = kUnits.find(*stop);
  if (stop + 1 != end || unit == std::string_view::npos) return 0;
  const std::size_t shift = 10 * (unit + 1);
  return value > std::numeric_limits<std::size_t>::max() >> shift ? 0 : value << shift;
}

}  // namespace

ReadBudget read_budget() {
  ReadBudget budget;
  if (const char* text = std::getenv(kMemoryVariable)) {
    budget.bytes = size_of(text);
    if (budget.bytes == 0) {
      throw UsageError(fmt::format("{}: found '{}', expected bytes, as 2000000000, 800M or 4G",
                                   kMemoryVariable, text));
    }
  }
  if (const char* text = std::getenv(kDepthVariable)) {
    const std::size_t depth = size_of(text);
    if (depth == 0 || depth > kMostDepth) {
      throw UsageError(fmt::format("{}: found '{}', expected a number from 1 to {}", kDepthVariable,
                                   text, kMostDepth));
    }
    budget.depth = static_cast<int>(depth);
  }
  return budget;
}

void check_memory(const std::string& what, std::size_t bytes) {
  const std::size_t most = read_budget().bytes;
  if (bytes <= most) return;
  throw InputError(fmt::format(
      "{}, which takes more than the {} bytes that the content of a file may take; if the file is "
      "right, set {} to more",
      what, most, kMemoryVariable));
}

void check_depth(const std::string& where, int depth) {
  const int most = read_budget().depth;
  if (depth <= most) return;
  throw InputError(fmt::format(
      "{}: nests more than {} values inside each other; if the file is right, set {} to more",
      where, most, kDepthVariable));
}

}  // namespace chasles
