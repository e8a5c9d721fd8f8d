#include <charconv>

#include <chasles/base/error.hpp>
#include <chasles/base/validate.hpp>
#include <chasles/pipeline/run_settings.hpp>
#include <chasles/smooth/batch/velocity_batch.hpp>

namespace chasles {
namespace {

void check_keyframes(const EstimatorChoice& choice) {
  if (choice.is_window() && choice.keyframes < 2) {
    throw UsageError("estimator: found a window of " + std::to_string(choice.keyframes) +
                     " keyframes, expected 2 or more");
  }
}

}  // namespace

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

std::string name_of(const EstimatorChoice& choice) {
  if (choice.is_window()) return "window:" + std::to_string(choice.keyframes);
  return choice.is_batch() ? "batch" : "filter";
}

void validate(const InertialRunSettings& settings) {
  validate(settings.filter);
  validate(settings.start);
  validate(settings.frontend);
  validate(settings.batch);
  check_keyframes(settings.estimator);
}

void validate(const VelocityRunSettings& settings) {
  validate(settings.filter);
  validate(settings.batch);
  check_keyframes(settings.estimator);
  if (!settings.estimator.is_filter()) check_smoothing(settings.filter);
}

}  // namespace chasles
