#pragma once

#include <span>
#include <string>
#include <string_view>

namespace chasles {

/// One condition of a start and its measured value at the latest attempt. Its texts are literals.
struct Requirement {
  std::string_view way;   ///< "static" or "dynamic": one way suffices, with all its conditions
  std::string_view name;  ///< for messages: "parallax"
  double measured = 0, threshold = 0;
  bool at_least =
      true;  ///< whether the measured value must be at least (true) or at most the threshold
  std::string_view unit;  ///< of both values; empty: a number
  bool met = false;
};

/// A condition with its result. A measured value that is NaN never meets it.
Requirement at_least(std::string_view name, double measured, double threshold,
                     std::string_view unit);
Requirement at_most(std::string_view name, double measured, double threshold,
                    std::string_view unit);

bool all_met(std::span<const Requirement> requirements);

/// One sentence with the conditions that are not met, as "not initialised after 2.1 s: static:
/// gyroscope standard deviation 0.21 rad/s of at most 0.014 rad/s; dynamic: parallax 3.1 px of at
/// least 10 px".
std::string why_not_initialised(double seconds, std::span<const Requirement> requirements);

}  // namespace chasles
