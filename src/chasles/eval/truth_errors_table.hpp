#pragma once

#include <chasles/eval/evaluation.hpp>
#include <chasles/eval/table.hpp>
#include <chasles/eval/truth_errors.hpp>

namespace chasles {

/// One row for each constant and axis: value, sigma, and whether it is significant.
Table truth_errors_table(const TruthErrors& errors);

/// The figures of the truth as it is, and without its errors.
Table without_truth_errors_table(const Evaluation& as_it_is, const TruthErrors& errors);

}  // namespace chasles
