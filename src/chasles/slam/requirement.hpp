#pragma once

#include <span>
#include <string>
#include <string_view>

namespace chasles {

/// One condition for a start and how far it was met when it was last looked at. Its texts are
/// literals.
struct Requirement {
  std::string_view way;  ///< "at rest" or "in motion": one way suffices, with all of its conditions
  std::string_view name;  ///< for a person: "parallax"
  double measured = 0, threshold = 0;
  bool at_least = true;   ///< measured has to be at least (true) or at most the threshold
  std::string_view unit;  ///< of both; empty: a number
  bool met = false;
};

/// A condition with its verdict; a measured value that is not a number never meets it.
Requirement at_least(std::string_view name, double measured, double threshold,
                     std::string_view unit);
Requirement at_most(std::string_view name, double measured, double threshold,
                    std::string_view unit);

bool all_met(std::span<const Requirement> requirements);

/// One sentence for a person, of the conditions that were not met: "not initialised after 2.1 s: at
/// rest: gyroscope deviation 0.21 rad/s of at most 0.014 rad/s; in motion: parallax 3.1 px of at
/// least 10 px".
std::string why_not_initialised(double seconds, std::span<const Requirement> requirements);

}  // namespace chasles
