#include <fmt/format.h>

#include <chasles/base/validate.hpp>
#include <chasles/lab/loops_settings.hpp>
#include <chasles/sim/reject_setting.hpp>

namespace chasles {
namespace {

// A step turns by less than a right angle, so that the steps follow the loop.
constexpr int kLeastStepsOfLoop = 4;

}  // namespace

void validate(const LoopsSettings& settings) {
  validate_fields(settings, kSimulationSetting);
  if (kLeastStepsOfLoop * settings.loops > settings.steps) {
    reject_setting(
        "loops", fmt::format("{}", settings.loops),
        fmt::format("at least {} steps a loop, so at most {} in {} steps", kLeastStepsOfLoop,
                    settings.steps / kLeastStepsOfLoop, settings.steps));
  }
}

}  // namespace chasles
