#pragma once

#include <optional>
#include <vector>

#include <chasles/eval/attitude_fit.hpp>
#include <chasles/eval/truth_path.hpp>
#include <chasles/eval/truth_reading.hpp>

// What rates alone leave open, as those of a drive in a plane: the positions give the rotation
// between the worlds, and with it the attitudes determine the reading and the axes on the body.
namespace chasles {

struct TruthForm {
  TruthReading reading = TruthReading::kAsRead;
  bool whole = false;  ///< the poses are inverse, not their rotations alone
};

/// The poses as world_T_body, if the truth has that form.
Trajectory in_form(const TruthForm& form, Trajectory truth);

/// Attitudes in the world of a path, with free axes on the body. A path that is nearly straight
/// leaves the rotation about itself open: then the attitudes decide that, too. Nothing where
/// neither does.
std::optional<AttitudeFit> attitudes_on_path(const Trajectory& estimate, const Trajectory& truth,
                                             const PositionFit& path, double offset, Time gap);

/// A truth in a form whose positions are those of the estimate.
struct FormFit {
  TruthForm form;
  PositionFit path;
  AttitudeFit attitudes;  ///< with the world of `path` and free axes on the body
};

/// All forms, from the simplest, in which the positions are of one path. `offset`: of the truth's
/// clock [s].
std::vector<FormFit> fit_forms(const Trajectory& estimate, const Trajectory& truth, double offset,
                               Time gap);

/// The form to take instead of the reading that the rates show (if any), where the attitudes
/// contradict that.
std::optional<TruthForm> contradicting_form(const std::vector<FormFit>& fits,
                                            std::optional<TruthReading> by_rates);

}  // namespace chasles
