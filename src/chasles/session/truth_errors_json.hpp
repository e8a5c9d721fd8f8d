#pragma once

#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include <chasles/eval/truth_errors.hpp>

namespace chasles {

/// What to say where the examination of the truth found something else.
inline constexpr std::string_view kMendTruthFirst =
    "--truth-errors auto: the constants are small errors, and what is named of the truth is none "
    "of "
    "them; mend it first";

/// The object `truth_errors` of `evaluate --json` and summary.json (docs/evaluation.md).
nlohmann::ordered_json truth_errors_json(const TruthErrors& errors);

}  // namespace chasles
