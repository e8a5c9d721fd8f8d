#include <array>
#include <utility>

#include <chasles/camera/judged_pixel.hpp>

namespace chasles {
namespace {

constexpr std::array<std::pair<Fate, const char*>, 4> kNames = {{{Fate::kWaiting, "waiting"},
                                                                 {Fate::kBegun, "begun"},
                                                                 {Fate::kUsed, "used"},
                                                                 {Fate::kRejected, "rejected"}}};

}  // namespace

const char* name(Fate fate) { return kNames[static_cast<std::size_t>(fate)].second; }

std::optional<Fate> fate_of(std::string_view name) {
  for (const auto& [fate, known] : kNames) {
    if (name == known) return fate;
  }
  return std::nullopt;
}

}  // namespace chasles
