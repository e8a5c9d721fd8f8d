#pragma once

#include <string>
#include <string_view>

namespace chasles {

/// A unit in one spelling, in small letters and without blanks: "m s^-2", "m·s⁻²" and
/// "metres*s**-2" are ms-2, and "degrees per second" and "°/s" are deg/s. Also of text in Latin-1.
std::string plain_unit(std::string_view unit);

}  // namespace chasles
