#pragma once

#include <chasles/data/recording.hpp>

namespace chasles::python {

/// The recording with images that several threads of Python may read: a run reads ahead while
/// another thread looks at them.
Recording shared(Recording recording);

}  // namespace chasles::python
