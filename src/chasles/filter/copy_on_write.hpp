#pragma once

#include <memory>

namespace chasles {

/// What copies share, for a change by one of them: it gets a copy of its own.
template <typename T>
T& own(std::shared_ptr<T>& shared) {
  if (shared.use_count() > 1) shared = std::make_shared<T>(*shared);
  return *shared;
}

}  // namespace chasles
