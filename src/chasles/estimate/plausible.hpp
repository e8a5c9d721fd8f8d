#pragma once

#include <chasles/estimate/estimate.hpp>
#include <chasles/filter/past/past.hpp>

// Whether an estimate of a visual-inertial filter can be true.
namespace chasles {

bool is_finite(const Estimate& e);
bool is_finite(const PastPose& pose);

/// The speed is unknown although there are many observations.
bool has_unknown_speed(const Estimate& e);

/// A frame contradicts the filter if it rejects a third of the compared observations, or a fifth
/// where the accepted ones have a large NIS per degree of freedom, if it uses almost none of many
/// observations, or if these leave the speed unknown. A wrong filter agrees with its youngest
/// landmarks. It initialises such landmarks in every frame, because the rejected ones are retired.
bool contradicted(const Estimate& e);

}  // namespace chasles
