#include "network.hpp"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

#include <chasles/base/error.hpp>

namespace chasles::bridge {
namespace {

// Without multicast a participant is found by its port, which its index determines: 33 participants
// of this machine are looked for.
const char* const kFindHere =
    "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
    "<Peers><Peer Address=\"127.0.0.1\"/></Peers>";

std::string configuration(const std::string& general, const std::string& discovery) {
  return fmt::format(
      "<CycloneDDS><Domain Id=\"any\"><General>{}<MaxMessageSize>65500B</MaxMessageSize></General>"
      "<Discovery>{}</Discovery></Domain></CycloneDDS>",
      general, discovery);
}

std::string interface(const std::string& attribute, const std::string& value) {
  return fmt::format("<Interfaces><NetworkInterface {}=\"{}\"/></Interfaces>", attribute, value);
}

bool is_address(const std::string& text) {
  return std::ranges::all_of(
      text, [](unsigned char c) { return std::isdigit(c) != 0 || c == '.' || c == ':'; });
}

bool is_name(const std::string& text) {
  return !text.empty() && std::ranges::all_of(text, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '.' || c == ':' || c == '-' || c == '_';
  });
}

}  // namespace

std::string network_configuration(const std::string& network) {
  if (network == "loopback" || network == "host") {
    const bool loopback = network == "loopback";
    return configuration((loopback ? interface("address", "127.0.0.1") : std::string()) +
                             "<AllowMulticast>false</AllowMulticast>",
                         kFindHere);
  }
  if (network == "any") return configuration("", "");
  if (!is_name(network)) {
    throw UsageError(
        fmt::format("--network: found '{}', expected loopback, host, any, or the name or address "
                    "of an interface",
                    network));
  }
  return configuration(interface(is_address(network) ? "address" : "name", network), "");
}

}  // namespace chasles::bridge
