#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <chasles/base/interruption.hpp>

namespace chasles {

struct SearchLimits {
  int iterations = 100;
  double damping = 1e-4;  ///< at the start
  /// The search ends where the linear problem expects less than this part of the cost, or
  double relative_decrease = 1e-12;
  /// less than this [of half a sum of whitened squares]: 1e-6 is 0.1 % of a standard deviation.
  double decrease = 1e-6;
};

template <typename State, typename Linearised>
struct Minimum {
  State state;
  Linearised linearised;  ///< there
  int iterations = 0;
  bool converged = false;
};

/// Levenberg-Marquardt. `linearise(state)` returns an optional object with `cost` and
/// `solve(damping)`, which returns an optional step with `decrease`; none: outside of what the
/// problem is defined for. `moved(state, step)` returns the next state, or none outside. None
/// where the start is outside.
template <typename State, typename Linearise, typename Move>
auto minimised(State state, const Linearise& linearise, const Move& moved,
               const SearchLimits& limits = {})
    -> std::optional<Minimum<State, typename decltype(linearise(state))::value_type>> {
  auto now = linearise(state);
  if (!now) return std::nullopt;
  double damping = limits.damping;
  int iteration = 0;
  bool converged = false;
  constexpr double kMostDamping = 1e10;
  while (iteration < limits.iterations && damping < kMostDamping) {
    interruption_point();
    ++iteration;
    const auto step = now->solve(damping);
    if (!step || !std::isfinite(step->decrease)) {
      damping = std::max(10 * damping, 1e-9);
      continue;
    }
    if (step->decrease <= limits.decrease + limits.relative_decrease * now->cost) {
      converged = true;
      break;
    }
    std::optional<State> next = moved(state, *step);
    auto after = next ? linearise(*next) : std::nullopt;
    if (!after || !(after->cost < now->cost)) {
      // Round-off of the cost hides what is left.
      if (after && step->decrease <= 1e-11 * now->cost) {
        converged = true;
        break;
      }
      damping = std::max(10 * damping, 1e-9);
      continue;
    }
    // A step that did what the linear problem expects needs less damping.
    const double gain = (now->cost - after->cost) / step->decrease;
    if (gain > 0.25) damping /= gain > 0.75 ? 10 : 2;
    damping = std::max(damping, 1e-12);
    state = std::move(*next);
    now = std::move(after);
  }
  return Minimum<State, typename decltype(linearise(state))::value_type>{
      std::move(state), std::move(*now), iteration, converged};
}

}  // namespace chasles
