#pragma once

#include <nlohmann/json_fwd.hpp>

#include <chasles/eval/truth_errors.hpp>

namespace chasles {

/// The object `truth_errors` of `evaluate --json` and summary.json (docs/evaluation.md).
nlohmann::ordered_json truth_errors_json(const TruthErrors& errors);

}  // namespace chasles
