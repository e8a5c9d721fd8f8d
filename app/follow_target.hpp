#pragma once

#include <memory>

#include <chasles/calibrate/live_capture.hpp>

#include "calibrate_views.hpp"

namespace chasles::app {

/// With `--live`: follows the folder of images while it is written, and shows what is seen and what
/// is missing, until the first Ctrl-C; with follows_target also what the motion of the IMU lacks.
/// Sets o.known to the images of the result, which must live as long. None without the option.
/// Throws UsageError for more than one recording and for a file, InputError as check_symmetry().
std::unique_ptr<LiveCapture> follow_target(ViewsOptions& o);

}  // namespace chasles::app
