#pragma once

#include <chasles/data/recording.hpp>

namespace chasles::fuzz {

/// What a program does with a recording once it is read: takes its events one by one, decodes its
/// images, and has it checked.
void use(const Recording& recording);

}  // namespace chasles::fuzz
