#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/shutter.hpp>

namespace chasles {

double checked_readout(const std::string& where, double seconds) {
  if (std::isfinite(seconds) && seconds >= 0 && seconds <= kLongestReadout) return seconds;
  throw InputError(fmt::format(
      "{}: is {}, expected the time in which the sensor reads out an image, in seconds, from 0 (a "
      "global shutter) to {}",
      where, seconds, kLongestReadout));
}

Shutter read_shutter(const YamlMap& map) {
  Shutter shutter;
  if (map.has("readout_time")) {
    shutter.readout = checked_readout(map.where("readout_time"), map.number("readout_time"));
  }
  if (!map.has("readout_direction")) return shutter;
  const std::string text = map.text("readout_direction");
  const auto direction = choice_of<ReadoutDirection>(text);
  if (!direction) {
    throw InputError(fmt::format("{}: is '{}', expected one of {}", map.where("readout_direction"),
                                 text, fmt::join(kChoiceNames<ReadoutDirection>, ", ")));
  }
  shutter.direction = *direction;
  return shutter;
}

std::string shutter_text(const Shutter& shutter, const std::string& indent) {
  if (!shutter.is_rolling()) return {};
  return fmt::format("{0}readout_time: {1}\n{0}readout_direction: {2}\n", indent, shutter.readout,
                     name_of(shutter.direction));
}

}  // namespace chasles
