#pragma once

#include <span>
#include <string>

#include <nlohmann/json.hpp>

namespace chasles {

/// What became better or worse since an earlier batch. `before`, `now`: records of two batches,
/// paired by their names. Entries: `better` and `worse`, the recordings with another verdict, each
/// with `before` and `now`; `only_before`, `only_now`: names; `figures`: of each figure that both
/// have the number of `pairs`, the geometric mean of now over before (`ratio`), and its 95 %
/// interval by the scatter of the pairs (`low`, `high`), null of fewer than two.
nlohmann::ordered_json batch_difference(std::span<const nlohmann::ordered_json> before,
                                        std::span<const nlohmann::ordered_json> now);

/// The same for a person.
std::string difference_text(const nlohmann::ordered_json& difference);

}  // namespace chasles
