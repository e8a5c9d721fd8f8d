#include <charconv>
#include <string>

#include <chasles/error.hpp>
#include <chasles/pipeline/run_settings.hpp>

namespace chasles {

EstimatorChoice estimator_choice(std::string_view text, std::string_view setting) {
  constexpr std::string_view kWindow = "window:";
  using Kind = EstimatorChoice::Kind;
  if (text == "filter") return {.kind = Kind::kFilter};
  if (text == "batch") return {.kind = Kind::kBatch};
  int keyframes = 0;
  if (text.starts_with(kWindow)) {
    const char* end = text.data() + text.size();
    const auto read = std::from_chars(text.data() + kWindow.size(), end, keyframes);
    if (read.ec == std::errc{} && read.ptr == end && keyframes >= 2) {
      return {.kind = Kind::kWindow, .keyframes = keyframes};
    }
  }
  throw UsageError(std::string(setting) + ": found '" + std::string(text) +
                   "', expected filter, batch or window:N with N of 2 or more");
}

}  // namespace chasles
