#include "use_recording.hpp"

#include <chasles/base/error.hpp>
#include <chasles/check/check.hpp>

namespace chasles::fuzz {

void use(const Recording& recording) {
  EventStream events(recording);
  while (const auto event = events.next()) {
    const auto* due = std::get_if<ImagesDue>(&*event);
    if (due == nullptr) continue;
    try {
      recording.images->read(due->index);
    } catch (const InputError&) {
      // A damaged image counts as missing.
    }
  }
  check_recording(recording);
}

}  // namespace chasles::fuzz
