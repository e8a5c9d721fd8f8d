#pragma once

#include <chasles/report/against_truth.hpp>
#include <chasles/viewers/channels.hpp>

namespace chasles {

/// Adds /state, chasles.State: the estimate and the statistics of its observations, one message per
/// state. The run's extra numbers have their own names, in which _ replaces invalid characters.
void add_states(const Run& run, Channels& out);

/// Adds /errors, chasles.Errors: truth minus estimate and NEES, one message per matched state.
void add_errors(const Run& run, const AgainstTruth& errors, Channels& out);

}  // namespace chasles
