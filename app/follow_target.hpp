#pragma once

#include <memory>

#include <chasles/calibrate/live_capture.hpp>

#include "calibrate_views.hpp"

namespace chasles::app {

/// `--live`: follows the folder of images while it is written, says what is seen and what is
/// missing, and returns at the first Ctrl-C, with what it has searched. Throws UsageError for more
/// than one recording and for a file, InputError as check_symmetry().
std::unique_ptr<LiveCapture> follow_target(const ViewsOptions& o);

}  // namespace chasles::app
