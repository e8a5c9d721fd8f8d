#pragma once

#include <chasles/report/against_truth.hpp>
#include <chasles/viewers/channels.hpp>

namespace chasles {

/// /state, chasles.State: what the filter believed and how its observations agreed, a message a
/// state, with the run's extra numbers by their names (what may not stand in a name becomes _).
void add_states(const Run& run, Channels& out);

/// /errors, chasles.Errors: truth less estimate and NEES, a message a matched state.
void add_errors(const Run& run, const AgainstTruth& errors, Channels& out);

}  // namespace chasles
