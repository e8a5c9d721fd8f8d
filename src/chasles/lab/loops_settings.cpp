#include <fmt/format.h>

#include <chasles/lab/loops_settings.hpp>
#include <chasles/sim/refuse_setting.hpp>
#include <chasles/base/validate.hpp>

namespace chasles {
namespace {

// A step turns by less than a right angle, so that the steps follow the loop.
constexpr int kLeastStepsOfLoop = 4;

}  // namespace

void validate(const LoopsSettings& settings) {
  validate_fields(settings, kSimulationSetting);
  if (kLeastStepsOfLoop * settings.loops > settings.steps) {
    refuse_setting(
        "loops", fmt::format("{}", settings.loops),
        fmt::format("at least {} steps a loop, so at most {} in {} steps", kLeastStepsOfLoop,
                    settings.steps / kLeastStepsOfLoop, settings.steps));
  }
}

}  // namespace chasles
