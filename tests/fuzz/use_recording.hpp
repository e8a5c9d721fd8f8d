#pragma once

#include <chasles/recording/recording.hpp>

namespace chasles::fuzz {

/// Uses a recording as a program does: takes its events one by one, decodes its images, and checks
/// it.
void use(const Recording& recording);

}  // namespace chasles::fuzz
