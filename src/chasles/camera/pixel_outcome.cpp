#include <array>
#include <utility>

#include <chasles/camera/pixel_outcome.hpp>

namespace chasles {
namespace {

constexpr std::array<std::pair<Outcome, const char*>, 4> kNames = {
    {{Outcome::kWaiting, "waiting"},
     {Outcome::kInitialised, "begun"},
     {Outcome::kUsed, "used"},
     {Outcome::kRejected, "rejected"}}};

}  // namespace

const char* name(Outcome outcome) { return kNames[static_cast<std::size_t>(outcome)].second; }

std::optional<Outcome> outcome_of(std::string_view name) {
  for (const auto& [outcome, known] : kNames) {
    if (name == known) return outcome;
  }
  return std::nullopt;
}

}  // namespace chasles
