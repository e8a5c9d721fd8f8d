#pragma once

#include <optional>

#include <chasles/eval/position_fit.hpp>

// The positions of a truth against those of an estimate: whether they are one path, and of what.
namespace chasles {

/// fit_positions() with a free scale. Where a point on the body explains the positions clearly
/// better, with that point; else with the point zero. `options`: `point` and `scale` have no
/// effect.
std::optional<PositionFit> fit_path(const Trajectory& estimate, const Trajectory& truth,
                                    PositionFitOptions options);

/// Whether what is left is a small part of the extent.
bool is_of_one_path(const std::optional<PositionFit>& fit);

/// Whether a point on the body is certain and explains what is left without it.
bool is_clear_point(const PositionFit& with, const PositionFit& without);

/// How well a path determines the rotation about its longest axis: what is left as a part of its
/// breadth [rad]. Large for a straight path.
double world_sigma(const PositionFit& fit);

/// Root mean square distance of the positions from their mean.
double spread(const Trajectory& poses);

/// Which columns of a truth are the latitude and the longitude in degrees, if its positions then
/// are those of the estimate and may be that.
enum class DegreesOrder { kLatitudeFirst, kLongitudeFirst };
std::optional<DegreesOrder> find_degrees(const Trajectory& estimate, const Trajectory& truth,
                                         const PositionFitOptions& options);

}  // namespace chasles
